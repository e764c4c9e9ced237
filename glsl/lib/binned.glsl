// Large splats, block by block: bin.comp has listed those that may touch a block. A thread takes a
// column of its block: a splat is fetched once for all of the column's pixels, and each pixel
// belongs to one thread, so that what a pass holds of it from splat to splat needs no atomics.
// Before it includes this, a pass defines
//   struct Held; Held held_begin(uint pixel); void held_end(uint pixel, Held held)
//   void held_take(inout Held held, bool hit, uint pixel, uint id, Splat s, Fragment f, uint encoded)
// Neither the order of a list nor how often a pixel is taken up again may show in the result.
#include "lib/record.glsl"

// Pixels of a thread.
#ifndef BINNED_ROWS
#define BINNED_ROWS 8
#endif
layout(local_size_x = STP_GROUP * STP_BLOCK / BINNED_ROWS) in; // STP_BLOCK blocks
const uint ROWS = BINNED_ROWS, PARTS = STP_BLOCK / ROWS;
// Entries after which a pass lets go of what it holds, so that sums of 2^20 stay below 2^31.
const uint TURNS = 1024;

// Entries are counted from 1: 0 ends a list. Returns the next one.
uint take(uint entry, uvec2 p, uint pixel, inout Held held[BINNED_ROWS])
{
    uint at = frame.splat_count + 2 * (entry - 1);
    Splat s;
    Footprint f;
    uint id = record_load(frame.bins.v[at], s, f), encoded = splat_encode(id, s);
    [[unroll]] for (uint i = 0; i < ROWS; i++) {
        Fragment fragment;
        uvec2 here = p + uvec2(0, i), whole = here + uvec2(frame.tile_x, frame.tile_y);
        bool hit = footprint_hit(f, s.phong, place_offset(f.p, whole), fragment);
        hit = hit && here.x < frame.tile_width && here.y < frame.tile_height;
        held_take(held[i], hit, pixel + i * STP_BLOCK, id, s, fragment, encoded);
    }
    return frame.bins.v[at + 1];
}

void main()
{
    const uint threads = STP_BLOCK * PARTS; // of a block
    uint count = frame.blocks_x * frame.blocks_y;
    uint index = workgroup_index() * STP_BLOCK + gl_LocalInvocationIndex / threads;
    if (index >= frame.work.v[STP_WORK_BINNED + 3])
        return;
    uint block = frame.work.v[STP_WORK_FLAGS + 3 * count + index];
    uint row = gl_LocalInvocationIndex % threads / STP_BLOCK * ROWS;
    uint column = gl_LocalInvocationIndex % STP_BLOCK;
    uint pixel = block * STP_GROUP + row * STP_BLOCK + column;
    uvec2 p = uvec2(block % frame.blocks_x, block / frame.blocks_x) * STP_BLOCK + uvec2(column, row);
    uint entry = frame.work.v[STP_WORK_FLAGS + 2 * count + block];
    while (entry != 0) {
        Held held[BINNED_ROWS];
        [[unroll]] for (uint i = 0; i < ROWS; i++)
            held[i] = held_begin(pixel + i * STP_BLOCK);
        for (uint n = 0; n < TURNS && entry != 0; n++)
            entry = take(entry, p, pixel, held);
        [[unroll]] for (uint i = 0; i < ROWS; i++)
            held_end(pixel + i * STP_BLOCK, held[i]);
    }
}
