#version 460
#extension GL_GOOGLE_include_directive : require
// The pixels that the push left empty, or in doubt: the nearest of the discs of the points in the
// pixels round about that reach it; in doubt, where that hides its own. The rest is open to discs from
// afar.
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

// The pixel stays as it is; a disc shows; nothing does; discs from afar decide.
const uint STAYS = 0, SHOWS = 1, NOTHING_SHOWS = 2, OPENS = 3;

bool far; // discs_far()

// Of a pixel without a point of its own.
uint outcome_of(bool hide, float reach, float mean)
{
    bool reached = reach < NOTHING;
    if (reached && !(mean <= reach))
        return SHOWS;
    if (far && (hide || !reached))
        return OPENS;
    return hide || reached || !(mean < NOTHING) ? STAYS : NOTHING_SHOWS;
}

// Which of the nine points the pixel shows, and its depth there; where it is open, the depth that discs
// have to be before by their radius. hide: what it shows is there, unless a disc hides it.
uint look(uvec2 p, uvec2 pixel, bool hide, out ivec2 point, out float nearest)
{
    vec2 q = rim_position(p);
    float reach = NOTHING, depth;
    Texel own = texel_load(0, ivec2(p));
    nearest = NOTHING;
    point = ivec2(p);
    for (int i = 0; i < 9; i++) {
        ivec2 at = ivec2(p) + ivec2(i % 3 - 1, i / 3 - 1);
        Texel t = texel_load(0, at);
        bool nearer = rim_hit(t, hide ? 0 : disc_crowd(t), q, depth) && texel_valid(t) && depth < nearest;
        reach = nearer ? depth + t.radius : reach;
        nearest = nearer ? depth : nearest;
        point = nearer ? at : point;
    }
    if (!texel_valid(own)) {
        float mean = rim_mean(pixel);
        uint outcome = outcome_of(hide, reach, mean);
        nearest = outcome == OPENS ? (hide ? mean : NOTHING) : nearest;
        return outcome;
    }
    float depth_own = own_depth(own, q);
    bool hidden = depth_own > reach;
    point = hidden ? point : ivec2(p);
    nearest = hidden ? nearest : depth_own;
    // Samples add up, so that the push has not written it; where discs reach far, the last pass does.
    return hidden || (SAMPLE_GRID > 1 && !far) ? SHOWS : far ? OPENS : STAYS;
}

// Two bits a turn of the thread through its block. Its pixels up to the next that changes: most stay.
void main()
{
    uint index = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (index >= frame.work.v[STP_WORK_LOOK + 3])
        return;
    far = discs_far();
    uint block = listed_block(LOOK, index), lane = gl_LocalInvocationIndex;
    uint left = frame.rim.v[block * STP_GROUP + lane];
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    uvec2 tile = uvec2(ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y));
    uvec2 open = uvec2(0);
    while (left != 0) {
        bool changes = false, shows = false;
        ivec2 point = ivec2(0);
        float depth = 0;
        uvec2 p = uvec2(0);
        for (; left != 0 && !changes; left &= left - 1) {
            uint turn = findLSB(left), i = lane + turn % STP_BLOCK * gl_WorkGroupSize.x;
            p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
            uint outcome = look(p, p - tile, turn >= STP_BLOCK, point, depth);
            shows = outcome == SHOWS;
            changes = shows || outcome == NOTHING_SHOWS;
            if (outcome == OPENS) {
                open |= open_bit(i);
                open_pixel(p, depth);
            }
        }
        if (changes)
            rim_write(ivec2(p), p - tile, !texel_valid(texel_load(0, ivec2(p))), shows, point, depth);
    }
    if (RIM_FAR)
        list_open(block, open);
}
