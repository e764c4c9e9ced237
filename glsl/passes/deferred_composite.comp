#version 460
#extension GL_GOOGLE_include_directive : require
// ZP Fig. 5: epsilon-z compositing of the K depth-images, then deferred shading. The images are
// keys (compute), or ids in the layers of an image (raster, FROM_IMAGE).
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#ifdef FROM_IMAGE
#define ALL_BLOCKS
#endif
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#ifdef FROM_IMAGE
layout(set = 0, binding = 1, r32ui) uniform readonly uimage2DArray ids;
#endif

struct Layer {
    float rho2, depth;
    vec3 normal;
    uint id;
};

Layer layer_none()
{
    return Layer(1, 1.0 / 0.0, vec3(0, 0, -1), STP_NO_ID);
}

Layer layer_by_id(uint id, uvec2 p)
{
    Layer l = layer_none();
    if (id != STP_NO_ID) {
        Splat s;
        Fragment f = fragment_again(id, p, s);
        l = Layer(f.rho2, f.depth, s.normal, id);
    }
    return l;
}

Layer layer_read(uint k, uint pixel, uvec2 p)
{
#ifdef FROM_IMAGE
    return layer_by_id(imageLoad(ids, ivec3(p, k)).x, p);
#else
    uint64_t key = frame.keys.v[pixel * K + k];
    if (!PACKED)
        return layer_by_id(uint(key), p);
    Layer l = layer_none();
    uint depth, normal;
    key_unpack(key, depth, l.rho2, normal);
    l.normal = normal_decode(normal);
    l.depth = key == ~0ul ? l.depth : depth_restore(depth);
    return l;
#endif
}

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    Layer layers[K];
    float near = 1.0 / 0.0;
    uint nearest = 0;
    [[unroll]] for (uint k = 0; k < K; k++) {
        layers[k] = layer_read(k, pixel, p);
        // Equal depths: the lower id, whatever its group.
        bool nearer = layers[k].depth < near ||
                      (layers[k].depth == near && layers[k].id < layers[nearest].id);
        near = min(near, layers[k].depth);
        nearest = nearer ? k : nearest;
    }
    bool hit = near < 1.0 / 0.0;
    Surface s = Surface(0, vec3(0), 0, vec3(0), vec3(0, 0, -1), near, STP_NO_ID, 0);
    [[unroll]] for (uint k = 0; k < K; k++) {
        if (k == nearest) {
            s.near_normal = layers[k].normal;
            s.id = layers[k].id;
        }
    }
    float limit = near + (hit ? object_epsilon(s.id) : 0);
    [[unroll]] for (uint k = 0; k < K; k++) {
        bool in_ = hit && layers[k].depth <= limit;
        float w = in_ ? kernel_weight(layers[k].rho2) : 0;
        s.weight += w;
        s.normal += w * layers[k].normal;
        s.depth += in_ ? w * (layers[k].depth - near) : 0;
        s.fragments += in_ ? 1 : 0;
        if (HAS_COLOR)
            s.albedo += w * frame.colors.v[in_ ? layers[k].id : 0];
    }
    s.depth = near + s.depth / s.weight;
    surface_write(p, hit, s);
}
