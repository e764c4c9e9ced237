#ifndef PIXEL_GLSL
#define PIXEL_GLSL
// Where a pixel's data lives: blocks of 8 x 8, row-major within the tile.
#include "lib/sample.glsl"

uint pixel_index(uvec2 p) // p relative to the tile
{
    uvec2 b = p / STP_BLOCK, i = p % STP_BLOCK;
    return (b.y * frame.blocks_x + b.x) * (STP_BLOCK * STP_BLOCK) + i.y * STP_BLOCK + i.x;
}

// Slot i of a pixel: slots of one rank lie together in a block, so that only the ranks that are used
// take memory.
uint slot_index(uint pixel, uint i)
{
    const uint block = STP_BLOCK * STP_BLOCK;
    return (pixel / block * STP_SLOTS + i) * block + pixel % block;
}

// The pixel of thread i of block b; false outside the tile.
bool block_pixel(uint b, uint i, out uvec2 p)
{
    p = uvec2(b % frame.blocks_x, b / frame.blocks_x) * STP_BLOCK +
        uvec2(i % STP_BLOCK, i / STP_BLOCK);
    return p.x < frame.tile_width && p.y < frame.tile_height;
}

// The pixel's sample, in the whole picture.
vec2 pixel_position(uvec2 p)
{
    uvec2 at = p + uvec2(frame.tile_x, frame.tile_y);
    return vec2(at) + sample_part(at);
}

// The host's triangles hide what is at or behind their depth.
bool behind_host(uint pixel, float depth)
{
    return HOST_DEPTH != 0 && depth >= uintBitsToFloat(frame.limits.v[pixel]);
}

#ifndef GRAPHICS
// Workgroups come in rows. Both halves of a dispatch run at once on a CPU device: neighbours in
// this order then share its cache. May reach past what was asked for: compare with the count.
uint workgroup_index()
{
    uint g = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint count = gl_NumWorkGroups.x * gl_NumWorkGroups.y, first = (count + 1) / 2;
    return g < first ? 2 * g : 2 * (g - first) + 1;
}
#endif
#endif
