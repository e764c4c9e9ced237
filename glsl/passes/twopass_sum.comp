#version 460
#extension GL_GOOGLE_include_directive : require
// The classical second pass: weighted sums of what lies within epsilon of the nearest, in fixed
// point, so that the order of the splats does not matter; of a transparent scene, of one layer.
#include "lib/common.glsl"
#ifdef WITH_ATOMIC64
#extension GL_EXT_shader_atomic_int64 : require
#endif
// Which variant draws a splat must not show.
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/sums.glsl"
#include "lib/peel.glsl"
#include "lib/light.glsl"

uint splat_encode(uint id, Splat s)
{
    return 0;
}

void sums_add(uint at, float value, float scale)
{
    PRECISE float whole = round(value * scale);
    uint64_t v = uint64_t(int64_t(whole));
#ifdef WITH_ATOMIC64
    atomicAdd(sums_buffer().v[at], v);
#else
    // Two 32-bit halves; the low one carries when it wraps.
    uint low = uint(v), high = uint(v >> 32);
    uint old = atomicAdd(sums_halves().v[2 * at], low);
    high += old + low < old ? 1 : 0;
    if (high != 0)
        atomicAdd(sums_halves().v[2 * at + 1], high);
#endif
}

// Of a fragment, its light too where splats are shaded.
PRECISE vec3 fragment_color(uint pixel, uint id, vec3 n, Fragment f)
{
    if (SHADE != 1)
        return frame.colors.v[id];
    uvec2 p;
    block_pixel(pixel / STP_GROUP, pixel % STP_GROUP, p);
    return shade_fragment(id, n, pixel_position(p), f.depth);
}

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    if (sums_skip(pixel))
        return;
    uint64_t first = sums_buffer().v[sums_at(pixel, 0)];
    float nearest = depth_ordered(uint(first >> 32)), epsilon = object_epsilon(uint(first));
    if (f.depth > nearest + epsilon || peel_other(pixel, id, f.depth, uint(first)))
        return;
    vec3 n = fragment_normal(s, f);
    PRECISE float w = kernel_weight(f.rho2), scale = frame.sum_scale;
    PRECISE float above = w * ((f.depth - nearest) / epsilon);
    sums_add(sums_at(pixel, 1), w, scale);
    sums_add(sums_at(pixel, 2), w * n.x, scale);
    sums_add(sums_at(pixel, 3), w * n.y, scale);
    sums_add(sums_at(pixel, 4), w * n.z, scale);
    sums_add(sums_at(pixel, 5), above, scale);
    if (HAS_COLOR || SHADE == 1) {
        vec3 c = fragment_color(pixel, id, n, f);
        sums_add(sums_at(pixel, 6), w * c.x, frame.color_scale);
        sums_add(sums_at(pixel, 7), w * c.y, frame.color_scale);
        sums_add(sums_at(pixel, 8), w * c.z, frame.color_scale);
    }
    if (OPACITY == 2)
        sums_add(sums_at(pixel, 10), w * splat_opacity(id), scale);
    if ((AOVS & 2) != 0)
        atomicAdd(sums_halves().v[2 * sums_at(pixel, 9)], 1);
}

#ifdef BINNED
#include "lib/held_sums.glsl"
#endif
#include "lib/rasterize.glsl"
