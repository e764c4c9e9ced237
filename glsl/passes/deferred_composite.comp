#version 460
#extension GL_GOOGLE_include_directive : require
// ZP Fig. 5: epsilon-z compositing of the K depth-images, then deferred shading. The images are
// keys (compute), or the layers of an image (raster, FROM_IMAGE).
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#ifdef FROM_IMAGE
#define IN_ROWS
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
    float rho2;  // by id, as what follows
    vec3 normal, albedo;
};

Layer layers[K];

Layer layer_none()
{
    return Layer(1.0 / 0.0, STP_NO_ID, uvec2(0), 1, vec3(0, 0, -1), vec3(0));
}

uvec2 layer_key(uint k, uint pixel, uvec2 p)
{
#ifdef FROM_IMAGE
    return imageLoad(winners, ivec3(p, k)).xy;
#else
    return unpackUint2x32(frame.keys.v[pixel * K + k]);
#endif
}

Layer layer_by_id(uint id, uvec2 p)
{
    Splat s;
    Fragment f = fragment_again(id, p, s);
    vec3 albedo = HAS_COLOR ? frame.colors.v[id] : vec3(0);
    return Layer(f.depth, id, uvec2(0), f.rho2, fragment_normal(s, f), albedo);
}

// Equal depths: the lower id, whatever its group.
void nearest_take(inout Layer nearest, Layer l)
{
    if (l.depth < nearest.depth || (!PACKED && l.depth == nearest.depth && l.id < nearest.id))
        nearest = l;
}

Layer layers_packed(uint pixel, uvec2 p)
{
    Layer nearest = layer_none();
    [[unroll]] for (uint k = 0; k < K; k++) {
        Layer l = layer_none();
        l.key = layer_key(k, pixel, p);
        l.depth = l.key == uvec2(~0u) ? l.depth : depth_restore(key_depth(l.key));
        layers[k] = l;
        nearest_take(nearest, l);
    }
    return nearest;
}

// A fragment made again by its id is much code, and most groups have none here: one copy of it, in
// as many turns as there are, where a copy for each group took seconds to compile. Layers move up,
// in the order of their groups; no index varies on them, so that they are registers.
Layer layers_by_id(uint pixel, uvec2 p)
{
    Layer nearest = layer_none();
    uvec2 left = uvec2(0);
    [[unroll]] for (uint k = 0; k < K; k++) {
        layers[k] = layer_none();
        left[k / 32] |= layer_key(k, pixel, p).x == STP_NO_ID ? 0 : 1u << k % 32;
    }
    for (uint turn = 0; left != uvec2(0); turn++) {
        bool low = left.x != 0;
        uint k = low ? findLSB(left.x) : 32 + findLSB(left.y);
        left &= low ? uvec2(left.x - 1, ~0u) : uvec2(0, left.y - 1);
        Layer l = layer_by_id(layer_key(min(k, K - 1), pixel, p).x, p);
        nearest_take(nearest, l);
        [[unroll]] for (uint i = 0; i < K; i++)
            if (i == turn)
                layers[i] = l;
    }
    return nearest;
}

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    Layer nearest = PACKED ? layers_packed(pixel, p) : layers_by_id(pixel, p);
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
            s.albedo += w * layers[k].albedo;
    }
    s.depth = near + s.depth / s.weight;
    surface_write(p, hit, s);
}
