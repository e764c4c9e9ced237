#version 460
#extension GL_GOOGLE_include_directive : require
// ZP Algorithms 2 and 3, compositing pass. The K blended images are averaged, those that cover the
// pixel only; NEAREST: behind the nearest layer, which is interpolated as in Fig. 5 and shaded. Depth,
// normal and the rest are the nearest layer's in either, and so is what it bends and mirrors.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define IN_ROWS
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#include "lib/transparent.glsl"
#include "lib/key.glsl"
#include "lib/glass.glsl"
layout(set = 0, binding = 1, rg32ui) uniform readonly uimage2DArray winners;
layout(set = 0, binding = 3, rgba32f) uniform readonly image2DArray blended;

struct Winner {
    uint id; // or what it adds, where PACKED
    float depth;
};

// A splat that won in several groups counts once; where PACKED, what has one normal and one depth: rho^2
// is of each group's own radius.
void read_winners(uvec2 p, out Winner w[K], out Winner nearest)
{
    nearest = Winner(STP_NO_ID, 1.0 / 0.0);
    [[unroll]] for (uint k = 0; k < K; k++) {
        uvec2 v = imageLoad(winners, ivec3(p, k)).xy;
        bool again = v.x == STP_NO_ID;
        [[unroll]] for (uint j = 0; j < k; j++)
            again = again || (PACKED ? w[j].id >> 8 == v.x >> 8 && w[j].depth == uintBitsToFloat(v.y)
                                     : w[j].id == v.x);
        w[k] = again ? Winner(STP_NO_ID, 1.0 / 0.0) : Winner(v.x, uintBitsToFloat(v.y));
        bool nearer = w[k].depth < nearest.depth ||
                      (w[k].depth == nearest.depth && w[k].id < nearest.id);
        nearest = Winner(nearer ? w[k].id : nearest.id, nearer ? w[k].depth : nearest.depth);
    }
}

vec3 winner_normal(Winner w, uvec2 p, out float rho2)
{
    if (PACKED) {
        rho2 = float(w.id & 255) * (1 / WINNER_RHO);
        return octahedral_decode(w.id >> 8, WINNER_NORMAL_BITS);
    }
    Splat splat;
    rho2 = fragment_again(w.id, p, splat).rho2;
    return splat.normal;
}

// The nearest layer: its sums, and its opacity.
Surface near_surface(uvec2 p, Winner w[K], Winner nearest, out float alpha)
{
    Surface s = Surface(0, vec3(0), 0, vec3(0), vec3(0, 0, -1), nearest.depth, nearest.id, 0);
    float limit = nearest.depth + object_epsilon(nearest.id);
    bool solid = splat_opaque(nearest.id);
    alpha = 0;
    [[unroll]] for (uint k = 0; k < K; k++) {
        if (!(w[k].depth <= limit) || splat_opaque(w[k].id) != solid)
            continue;
        float rho2;
        vec3 normal = winner_normal(w[k], p, rho2);
        float weight = kernel_weight(rho2);
        s.weight += weight;
        s.normal += weight * normal;
        s.depth += weight * (w[k].depth - nearest.depth);
        s.fragments++;
        if (HAS_COLOR)
            s.albedo += weight * frame.colors.v[w[k].id];
        alpha += weight * splat_opacity(w[k].id);
        if (w[k].id == nearest.id)
            s.near_normal = normal;
    }
    s.depth = nearest.depth + s.depth / s.weight;
    alpha = s.weight > 0 ? alpha / s.weight : splat_opacity(nearest.id);
    return s;
}

// The mean of the images that cover the pixel.
vec4 mean_blended(uvec2 p)
{
    vec4 sum = vec4(0);
    float count = 0;
    [[unroll]] for (uint k = 0; k < K; k++) {
        vec4 c = imageLoad(blended, ivec3(p, k));
        sum += c;
        count += c.w > 0 ? 1 : 0;
    }
    return sum / max(count, 1);
}

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    Winner w[K], nearest;
    read_winners(p, w, nearest);
    bool hit = nearest.id != STP_NO_ID;
    Surface s = Surface(0, vec3(0), 0, vec3(0), vec3(0, 0, -1), 0, STP_NO_ID, 0);
    float alpha = 0;
    if (hit)
        s = near_surface(p, w, nearest, alpha);
    Look look = surface_look(p, hit, s);
    vec4 color = mean_blended(p), all = color;
    bool clear = !splat_opaque(nearest.id);
#ifdef NEAREST
    if (!clear)
        surface_meet(look, p, hit, s);
    vec3 near = alpha * look.color;
    all = vec4(near, alpha) + (1 - alpha) * color;
    LayersLight glass = LayersLight(near, (1 - alpha) * color, alpha);
#else
    LayersLight glass = LayersLight(vec3(0), color, alpha);
#endif
    if ((OPTICS & STP_OPTICS_GLASS) != 0 && hit && clear)
        glass_show(glass, p, look, s, all);
    picture_write(p, hit, all, look, s, 0);
}
