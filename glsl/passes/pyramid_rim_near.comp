#version 460
#extension GL_GOOGLE_include_directive : require
// The pixels that the push left empty, or in doubt: the nearest of the discs of the points in the
// pixels round about that reach it; in doubt, where that hides its own.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
#include "lib/rim.glsl"
#define SURFACE_OBJECT(s) surface_object
uint surface_object;
#include "lib/shade.glsl"
#include "lib/own.glsl"
#include "lib/push.glsl"
#include "lib/rim_surface.glsl"
layout(local_size_x_id = 22) in;

// Which of the nine points the pixel shows, and its depth there. False: nothing changes.
bool look(uvec2 p, out ivec2 point, out float nearest)
{
    vec2 q = rim_position(p);
    float reach = NOTHING, depth;
    Texel own = texel_load(0, ivec2(p));
    bool doubtful = texel_valid(own);
    nearest = NOTHING;
    point = ivec2(p);
    for (int i = 0; i < 9; i++) {
        ivec2 at = ivec2(p) + ivec2(i % 3 - 1, i / 3 - 1);
        Texel t = texel_load(0, at);
        bool nearer = rim_hit(t, doubtful ? 0 : disc_crowd(t), q, depth) && texel_valid(t) && depth < nearest;
        reach = nearer ? depth + t.radius : reach;
        nearest = nearer ? depth : nearest;
        point = nearer ? at : point;
    }
    if (!doubtful && nearest < NOTHING)
        UintRef(uint64_t(frame.keys)).v[2 * grid_index(p)] = STP_NO_POINT;
    if (!doubtful)
        return nearest < NOTHING;
    float depth_own = own_depth(own, q);
    bool hidden = depth_own > reach;
    point = hidden ? point : ivec2(p);
    nearest = hidden ? nearest : depth_own;
    return hidden || SAMPLE_GRID > 1; // samples add up, so that the push has not written it
}

// A thread's pixels up to the next that changes: most of those in doubt do not.
void main()
{
    uint first = workgroup_index() * STP_GROUP, count = frame.work.v[STP_WORK_EMPTY + 3];
    uint end = min(first + STP_GROUP, count);
    uvec2 tile = uvec2(ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y));
    for (uint i = first + gl_LocalInvocationIndex; i < end;) {
        bool changes = false;
        ivec2 point = ivec2(0);
        float depth = 0;
        uvec2 p = uvec2(0);
        for (; i < end && !changes; i += gl_WorkGroupSize.x) {
            uint at = frame.rim.v[min(i, end - 1)]; // loads are not always masked
            p = uvec2(at % frame.grid_width, at / frame.grid_width);
            changes = look(p, point, depth);
        }
        if (changes)
            surface_write(p - tile, true, rim_surface(ivec2(p), rim_position(p), point, depth));
    }
}
