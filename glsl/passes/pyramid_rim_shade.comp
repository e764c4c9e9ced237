#version 460
#extension GL_GOOGLE_include_directive : require
// The open pixels: what the nearest disc shows, where one reached them and, if they show something,
// hides that.
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
layout(local_size_x_id = PLAN_LANES) in;

struct Settled {
    bool changes; // else the pixel stays as it is
    bool shows;   // the point of level 0, or its mean; else nothing
    bool bare;    // none was left in the pixel
    float depth;
};

// Of a pixel that a disc had to cover, and none did, nothing stays.
Settled settle(uvec2 p, uvec2 pixel, uvec2 key)
{
    bool reached = key.x < STP_RIM_NONE, showed = open_limit(p) < NOTHING;
    float depth = depth_ordered(key.y), mean = rim_mean(pixel);
    Texel t = texel_load(0, ivec2(p));
    if (!showed)
        return Settled(reached ? !(mean <= depth + t.radius) : mean < NOTHING, reached, true, depth);
    // Samples add up, so that the push has not written it.
    return Settled(reached || SAMPLE_GRID > 1, true, false, reached ? depth : own_depth(t, rim_position(p)));
}

// A thread's pixels up to the next that changes.
void main()
{
    uint index = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (index >= frame.work.v[STP_WORK_OPEN + 3])
        return;
    uint block = listed_block(OPEN, index);
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    uvec2 tile = uvec2(ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y));
    uvec2 open = uvec2(frame.work.v[open_word(block, 0)], frame.work.v[open_word(block, 1)]);
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP;) {
        Settled s = Settled(false, false, false, 0);
        uvec2 p = corner;
        for (; i < STP_GROUP && !s.changes; i += gl_WorkGroupSize.x) {
            if (any(notEqual(open & open_bit(i), uvec2(0)))) {
                p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
                uvec2 key = unpackUint2x32(frame.keys.v[block * STP_GROUP + i]);
                s = settle(p, p - tile, key);
            }
        }
        if (s.changes)
            rim_write(ivec2(p), p - tile, s.bare, s.shows, ivec2(p), s.depth);
    }
}
