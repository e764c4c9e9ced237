#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.1: every point to one pixel, by one atomic. Depth decides, ties go to the lower id. An
// invocation takes many points: starting one costs a CPU device as much as projecting several.
#include "lib/common.glsl"
#extension GL_EXT_shader_atomic_int64 : require
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/points.glsl"
layout(local_size_x_id = 22) in;

void project(uint index)
{
    Splat s;
    uvec2 pixel;
    vec2 offset;
    bool seen = point_load(index, s);
    if (!point_pixel(s, pixel, offset) || !seen)
        return;
    uint at = grid_index(pixel), depth = depth_order(s.center.z), id = push_first + index;
    atomicMin(frame.keys.v[at], uint64_t(depth) << 32 | id);
}

void main()
{
    uint first = workgroup_index() * STP_POINT_RUN;
    for (uint i = gl_LocalInvocationIndex; i < STP_POINT_RUN; i += gl_WorkGroupSize.x)
        if (first + i < push_count)
            project(first + i);
}
