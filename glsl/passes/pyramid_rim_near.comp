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
layout(local_size_x_id = 22) in;

void fill(uvec2 p, uvec2 pixel)
{
    vec2 q = rim_position(p);
    float nearest = NOTHING, reach = NOTHING, depth;
    ivec2 point = ivec2(p);
    Texel own = texel_load(0, ivec2(p));
    bool doubtful = texel_valid(own);
    for (int i = 0; i < 9; i++) {
        ivec2 at = ivec2(p) + ivec2(i % 3 - 1, i / 3 - 1);
        Texel t = texel_load(0, at);
        bool nearer = rim_hit(t, doubtful ? 0 : disc_crowd(t), q, depth) && texel_valid(t) && depth < nearest;
        reach = nearer ? depth + t.radius : reach;
        nearest = nearer ? depth : nearest;
        point = nearer ? at : point;
    }
    if (!(nearest < NOTHING) && !doubtful)
        return;
    Surface kept = own_surface(own, q, ivec2(p));
    bool keeps = doubtful && !(kept.depth > reach);
    Texel t = texel_load(0, point);
    Attributes a = attributes_load(0, point);
    Surface s = Surface(1, t.normal, nearest, a.color, t.normal, nearest, a.id, 1);
    if (keeps)
        s = kept;
    else
        surface_object = a.object;
    s.albedo /= frame.pyramid_color;
    surface_write(pixel, true, s);
    if (!doubtful)
        UintRef(uint64_t(frame.keys)).v[2 * grid_index(p)] = STP_NO_POINT;
}

void main()
{
    uint first = workgroup_index() * STP_GROUP, count = frame.work.v[STP_WORK_EMPTY + 3];
    uvec2 tile = uvec2(ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y));
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP; i += gl_WorkGroupSize.x) {
        if (first + i >= count)
            continue;
        uint at = frame.rim.v[first + i];
        uvec2 p = uvec2(at % frame.grid_width, at / frame.grid_width);
        fill(p, p - tile);
    }
}
