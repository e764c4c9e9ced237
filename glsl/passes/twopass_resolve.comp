#version 460
#extension GL_GOOGLE_include_directive : require
// Normalisation and deferred shading of the two-pass sums (ZP 3.1, third pass); of a transparent scene,
// of one more layer.
// SURE: pixels whose sums vanish, which need the nearest fragment itself, are left to VANISHED, and
// that is sent only if there are any: the fragment of an ellipse costs more than all the rest.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/sums.glsl"
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#define RESOLVES
#include "lib/peel.glsl"

// Another variant's pixel.
bool leave(bool hit, Surface s)
{
    bool vanished = hit && surface_vanished(s);
#ifdef SURE
    if (vanished)
        for (uint i = 0; i < 2; i++)
            frame.work.v[STP_WORK_LOOK + i] = frame.work.v[STP_WORK_BLOCKS + i];
    return vanished;
#elif defined(VANISHED)
    return !vanished;
#else
    return false;
#endif
}

float sum(uint at, float scale)
{
    return float(int64_t(sums_buffer().v[at])) / scale;
}

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel) || sums_skip(pixel))
        return;
    uint64_t first = sums_buffer().v[sums_at(pixel, 0)];
    bool hit = first != STP_SUMS_NONE;
    Surface s;
    s.id = uint(first);
    s.near_depth = depth_ordered(uint(first >> 32));
    float scale = frame.sum_scale;
    s.weight = sum(sums_at(pixel, 1), scale);
    s.normal = vec3(sum(sums_at(pixel, 2), scale), sum(sums_at(pixel, 3), scale), sum(sums_at(pixel, 4), scale));
    s.depth = s.near_depth + sum(sums_at(pixel, 5), scale) / s.weight * (hit ? object_epsilon(s.id) : 0);
    if (HAS_COLOR || SHADE == 1)
        s.albedo = vec3(sum(sums_at(pixel, 6), frame.color_scale), sum(sums_at(pixel, 7), frame.color_scale),
                        sum(sums_at(pixel, 8), frame.color_scale));
    s.fragments = 0;
    if ((AOVS & 2) != 0)
        s.fragments = uint(sums_buffer().v[sums_at(pixel, 9)]);
    s.near_normal = vec3(0, 0, -1);
    if (leave(hit, s))
        return;
#ifndef SURE
    if (hit)
        s.near_normal = normal_again(s.id, p);
#endif
    if (SHADE == 2)
        s = Surface(1, s.near_normal, s.near_depth, vec3(0), s.near_normal, s.near_depth, s.id, 1);
    if (!PEEL) {
        surface_write(p, hit, s);
        return;
    }
    float alpha = splat_opacity(s.id);
    if (OPACITY == 2 && s.weight > 0)
        alpha = sum(sums_at(pixel, 10), scale) / s.weight;
    peel_write(p, pixel, hit, s, alpha);
}
