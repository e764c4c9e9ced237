#version 460
#extension GL_GOOGLE_include_directive : require
// ZP Fig. 5: epsilon-z compositing of the K depth-images, then deferred shading. The images are
// keys (compute), or the layers of an image (raster, FROM_IMAGE).
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#ifdef FROM_IMAGE
#define ALL_BLOCKS
#endif
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#ifdef FROM_IMAGE
layout(set = 0, binding = 1, rg32ui) uniform readonly uimage2DArray winners;
#endif

// One fragment of the pixel. Packed layers stay packed until they are known to count.
struct Layer {
    float depth;
    uint id;
    uvec2 key;   // PACKED
    float rho2;  // by id
    vec3 normal; // by id
};

Layer layer_none()
{
    return Layer(1.0 / 0.0, STP_NO_ID, uvec2(0), 1, vec3(0, 0, -1));
}

Layer layer_by_id(uint id, uvec2 p)
{
    Layer l = layer_none();
    if (id != STP_NO_ID) {
        Splat s;
        Fragment f = fragment_again(id, p, s);
        l = Layer(f.depth, id, uvec2(0), f.rho2, fragment_normal(s, f));
    }
    return l;
}

Layer layer_read(uint k, uint pixel, uvec2 p)
{
#ifdef FROM_IMAGE
    uvec2 key = imageLoad(winners, ivec3(p, k)).xy;
#else
    uvec2 key = unpackUint2x32(frame.keys.v[pixel * K + k]);
#endif
    if (!PACKED)
        return layer_by_id(key.x, p);
    Layer l = layer_none();
    l.key = key;
    l.depth = key == uvec2(~0u) ? l.depth : depth_restore(key_depth(key));
    return l;
}

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    Layer layers[K];
    Layer nearest = layer_none();
    [[unroll]] for (uint k = 0; k < K; k++) {
        layers[k] = layer_read(k, pixel, p);
        // Equal depths: the lower id, whatever its group.
        if (layers[k].depth < nearest.depth ||
            (!PACKED && layers[k].depth == nearest.depth && layers[k].id < nearest.id))
            nearest = layers[k];
    }
    float near = nearest.depth;
    bool hit = near < 1.0 / 0.0;
    float limit = near + (hit ? object_epsilon(nearest.id) : 0);
    Surface s = Surface(0, vec3(0), 0, vec3(0), vec3(0), near, nearest.id, 0);
    s.near_normal = PACKED ? key_normal(nearest.key) : nearest.normal;
    [[unroll]] for (uint k = 0; k < K; k++) {
        bool counts = hit && layers[k].depth <= limit;
        float rho2 = PACKED ? key_rho2(layers[k].key) : layers[k].rho2;
        float w = counts ? kernel_weight(rho2) : 0;
        s.weight += w;
        s.normal += w * (PACKED ? key_normal(layers[k].key) : layers[k].normal);
        s.depth += counts ? w * (layers[k].depth - near) : 0;
        s.fragments += counts ? 1 : 0;
        if (HAS_COLOR)
            s.albedo += w * frame.colors.v[counts ? layers[k].id : 0];
    }
    s.depth = near + s.depth / s.weight;
    surface_write(p, hit, s);
}
