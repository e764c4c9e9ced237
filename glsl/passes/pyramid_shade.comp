#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.3 for level 0, and 3.4: the picture's pixels, shaded as those of every method are.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
#include "lib/push.glsl"
#include "lib/rim.glsl"
#define SURFACE_OBJECT(s) surface_object
uint surface_object;
#include "lib/shade.glsl"
#include "lib/own.glsl"
layout(local_size_x_id = PLAN_LANES) in;

// What is left to the passes over the rim: nothing; whether a disc covers the pixel; whether one hides
// what it shows; discs from afar alone.
const uint DONE = 0, COVER = 1, HIDE = 2, AFAR = 3;

uint shade_pixel(ivec2 p, uvec2 pixel)
{
    vec2 q = vec2(p + ivec2(frame.grid_x, frame.grid_y)) +
             (sample_part(pixel + uvec2(frame.tile_x, frame.tile_y)) - sample_shift());
    Texel own = texel_load(0, p);
    bool valid = texel_valid(own);
    Pushed r = push_from(1, p, q, valid);
    // A mean's plane may reach beyond near and far, its disc beyond the union of its points'.
    bool there = r.weight > 0 && r.depth >= frame.near_depth && r.depth <= frame.far_depth;
    Surface s = own_surface(own, q, p);
    bool copied = valid && !(there && s.depth > r.reach);
    if (!copied) {
        s = Surface(r.weight, r.normal, r.depth, r.attributes.color, r.disc.normal, r.depth,
                    r.attributes.id, r.count);
        surface_object = r.attributes.object;
    }
    s.albedo /= frame.pyramid_color;
    // On the rim a mean stands until the points' discs refuse it; but samples add up.
    bool rim = !valid && r.disc.rim, hit = valid || (there && !(rim && SAMPLE_GRID > 1));
    // What lies behind a texel whose mean disc misses it may be hidden by the points' own discs; but a
    // mean of one of several samples stands as it is.
    bool doubtful = hit && !rim && s.depth > r.before && (copied || SAMPLE_GRID == 1);
    if (!doubtful || SAMPLE_GRID == 1)
        surface_write(pixel, hit, s);
    if (hit && !rim)
        return doubtful ? HIDE : DONE;
    return r.beside ? COVER : AFAR;
}

void main()
{
    uint index = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (index >= frame.work.v[STP_WORK_BLOCKS + 3])
        return;
    uint block = listed_block(TOUCHED, index), again = 0, turn = 1;
    uvec2 open = uvec2(0);
    bool far = discs_far();
    ivec2 corner = ivec2(block % columns, block / columns) * STP_BLOCK;
    ivec2 tile = ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y);
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP; i += gl_WorkGroupSize.x, turn <<= 1) {
        ivec2 p = corner + ivec2(i % STP_BLOCK, i / STP_BLOCK), pixel = p - tile;
        uint left = DONE;
        if (all(greaterThanEqual(pixel, ivec2(0))) &&
            all(lessThan(pixel, ivec2(frame.tile_width, frame.tile_height))))
            left = shade_pixel(p, uvec2(pixel));
        again |= left == COVER ? turn : left == HIDE ? turn << STP_BLOCK : 0;
        if (far && left == AFAR) {
            open |= open_bit(i);
            open_pixel(uvec2(p), NOTHING);
        }
    }
    frame.rim.v[block * STP_GROUP + gl_LocalInvocationIndex] = again;
    if (again != 0)
        list_block(LOOK, STP_WORK_LOOK, STP_BLOCK_LOOK, block);
    if (RIM_FAR)
        list_open(block, open);
}
