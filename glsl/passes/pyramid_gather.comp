#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.1: the attributes of the points that won their pixels become level 0, which starts empty. Of
// points that stream in chunks, those of this chunk; what earlier ones left stays.
#include "lib/common.glsl"
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
#include "lib/discs.glsl"
layout(local_size_x_id = PLAN_LANES) in;
#ifdef FETCHED
layout(set = 0, binding = STP_BINDING_SLOTS) uniform utextureBuffer key_texels;
#endif

// Of the point that won a pixel. FETCHED: read as texels, which a software device gathers at once where
// loads through an address take a turn a lane. Neither is always masked.
uint winner(uint pixel)
{
#ifdef FETCHED
    return texelFetch(key_texels, int(pixel)).x;
#else
    return UintRef(uint64_t(frame.keys)).v[2 * pixel];
#endif
}

void gather(uvec2 p, uint index, bool found)
{
    Place place;
    uvec2 pixel;
    vec2 offset;
    uvec4 point = texelFetch(point_texels, int(index));
    float depth = point_place(uintBitsToFloat(point.xyz), place);
    Texel t = point_disc(index, point, depth, place);
    point_pixel(place, pixel, offset);
    t.center = level_middle(0, ivec2(p)) + offset;
    if (!found)
        return;
    texel_store(0, ivec2(p), t);
#if ATTRIBUTES > 0
    attributes_store(0, ivec2(p), point_attributes(index));
#endif
}

// A thread's pixels up to its next winner, which lets a CPU device pass over what is empty.
void main()
{
    uint block = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (block >= columns * (frame.grid_height / STP_BLOCK))
        return;
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    bool some = false;
    disc_view_keep();
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP;) {
        bool found = false;
        uint index = 0;
        uvec2 p = corner;
        for (; i < STP_GROUP && !found; i += gl_WorkGroupSize.x) {
            uint id = winner(block * STP_GROUP + min(i, STP_GROUP - 1));
            p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
            found = id - push_first < push_count;
            index = found ? id - push_first : 0;
        }
        gather(p, index, found);
        some = some || found;
    }
    if (some)
        frame.work.v[STP_WORK_FLAGS + block] = STP_BLOCK_POINTS;
}
