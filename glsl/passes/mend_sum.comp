#version 460
#extension GL_GOOGLE_include_directive : require
// Mending, geometry: FIND looks for the first layer and for what is opaque; else the fragments of
// the layer at hand are summed, in fixed point, and the start of the next one is found.
#include "lib/common.glsl"
#extension GL_EXT_shader_atomic_int64 : require
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/mend.glsl"

uint splat_encode(Splat s)
{
    return 0;
}

#ifdef FIND

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    if (mend_skip(pixel) || behind_host(pixel, f.depth))
        return;
    bool opaque = MIXED && (s.tag & STP_TAG_OPAQUE) != 0;
    atomicMin(frame.keys.v[mend_at(pixel, opaque ? MEND_WALL : MEND_NEXT)],
              uint64_t(depth_order(f.depth)) << 32 | id);
}

#else

void add(uint pixel, uint word, float value, float scale)
{
    atomicAdd(frame.keys.v[mend_at(pixel, MEND_SUMS + word)],
              uint64_t(int64_t(round(value * scale))));
}

void sum(uint pixel, uint id, Splat s, Fragment f, float above)
{
    vec3 n = fragment_normal(s, f);
    float w = kernel_weight(f.rho2), scale = frame.sum_scale;
    add(pixel, 0, w, scale);
    add(pixel, 1, w * n.x, scale);
    add(pixel, 2, w * n.y, scale);
    add(pixel, 3, w * n.z, scale);
    add(pixel, 4, w * above, scale);
    if (HAS_COLOR) {
        vec3 c = frame.colors.v[id];
        add(pixel, 5, w * c.x, frame.color_scale);
        add(pixel, 6, w * c.y, frame.color_scale);
        add(pixel, 7, w * c.z, frame.color_scale);
    }
    if (OPACITY == 2)
        add(pixel, 8, w * splat_opacity(id), scale);
    atomicAdd(frame.keys.v[mend_at(pixel, MEND_SUMS + 9)], 1ul);
}

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    if (mend_skip(pixel) || behind_host(pixel, f.depth))
        return;
    uint64_t now = frame.keys.v[mend_at(pixel, MEND_NOW)];
    uint64_t wall = frame.keys.v[mend_at(pixel, MEND_WALL)];
    bool solid = MIXED && now == wall, opaque = MIXED && (s.tag & STP_TAG_OPAQUE) != 0;
    float near = mend_depth(now), epsilon = object_epsilon(uint(now));
    if (now == STP_SUMS_NONE || opaque != solid || f.depth < near ||
        (!solid && f.depth >= mend_depth(wall)))
        return;
    if (f.depth <= near + epsilon)
        sum(pixel, id, s, f, (f.depth - near) / epsilon);
    else if (!solid)
        atomicMin(frame.keys.v[mend_at(pixel, MEND_NEXT)], uint64_t(depth_order(f.depth)) << 32 | id);
}

#endif

#include "lib/rasterize.glsl"
