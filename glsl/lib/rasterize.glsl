// The compute rasteriser. A pass defines, before it includes this,
//   void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
// Small splats: a thread each (LISTED: only those that exact_collect found). Splats that are large
// or cross the near plane go to a list. With BINS the BINNED variant of the same pass draws them block
// by block; each of those that are left takes a workgroup of its LARGE variant. Needs lib/pixel.glsl.

#ifdef BINNED
#include "lib/binned.glsl"
#else

#ifdef LARGE
layout(local_size_x = STP_LARGE_GROUP) in;
#include "lib/clipped.glsl"
#else
layout(local_size_x = STP_GROUP) in;
#endif

void visit(uint id, Splat s, Footprint f, bool clipped, uint encoded, uvec2 pixel)
{
    Fragment fragment;
    if (clipped ? clipped_hit(s, pixel, fragment)
                : footprint_hit(f, s.phong, place_offset(f.p, pixel), fragment))
        fragment_emit(pixel_index(pixel - uvec2(frame.tile_x, frame.tile_y)), id, s, fragment,
                      encoded);
}

#ifdef LARGE
// All threads of the group: a tile may have more blocks than the 65535 turns that lavapipe allows.
void touch_blocks(ivec4 box)
{
    uvec4 b = uvec4(box - ivec2(frame.tile_x, frame.tile_y).xyxy) / STP_BLOCK;
    uint width = b.z - b.x + 1, count = width * (b.w - b.y + 1);
    for (uint i = gl_LocalInvocationIndex; i < count; i += STP_LARGE_GROUP)
        frame.work.v[STP_WORK_FLAGS + (b.y + i / width) * frame.blocks_x + b.x + i % width] =
            STP_BLOCK_TOUCHED;
}
#else
void touch_blocks(ivec4 box)
{
    ivec4 b = (box - ivec2(frame.tile_x, frame.tile_y).xyxy) / STP_BLOCK;
    int width = b.z - b.x + 1, count = width * (b.w - b.y + 1), x = b.x, y = b.y;
    for (int i = 0; i < count; i++) {
        frame.work.v[STP_WORK_FLAGS + y * frame.blocks_x + x] = STP_BLOCK_TOUCHED;
        if (++x > b.z) {
            x = b.x;
            y++;
        }
    }
}
#endif

#ifdef LARGE

// The pixels of the blocks that a box touches: those that its splat would be tried at if it were binned.
ivec4 whole_blocks(ivec4 box)
{
    ivec4 low = ivec2(frame.tile_x, frame.tile_y).xyxy;
    ivec4 b = (box - low) / STP_BLOCK * STP_BLOCK + ivec4(0, 0, STP_BLOCK - 1, STP_BLOCK - 1);
    ivec2 last = ivec2(frame.tile_width, frame.tile_height) - 1;
    return box.z < box.x ? box : low + ivec4(b.xy, min(b.zw, last));
}

// A workgroup a splat; its threads step through the rectangle together.
void main()
{
    uint index = gl_WorkGroupID.y * STP_ROW + gl_WorkGroupID.x;
    if (index >= frame.work.v[(BINS ? STP_WORK_REST : STP_WORK_LARGE) + 3])
        return;
    uint id = BINS ? frame.bins.v[index] : frame.large.v[index];
    Splat s;
    splat_load(id, s);
    bool floored;
    Footprint f = footprint_make(s, floored);
    bool clipped = splat_clipped(s, floored);
    ivec4 box = clipped ? clipped_pixels(s) : footprint_pixels(s, f, floored);
    if (BINS && !clipped)
        box = whole_blocks(box);
    uint width = uint(box.z - box.x + 1), count = width * uint(box.w - box.y + 1);
    uint encoded = splat_encode(id, s);
#ifdef FIRST_PASS
    if (count > 0)
        touch_blocks(box);
#endif
    for (uint i = gl_LocalInvocationIndex; i < count; i += STP_LARGE_GROUP)
        visit(id, s, f, clipped, encoded, uvec2(box.xy) + uvec2(i % width, i / width));
}

#else

#ifdef FIRST_PASS
void defer_large(uint id)
{
    uint slot = atomicAdd(frame.work.v[STP_WORK_LARGE + 3], 1);
    frame.large.v[slot] = id;
    atomicMax(frame.work.v[STP_WORK_LARGE], min(slot + 1, STP_ROW));
    atomicMax(frame.work.v[STP_WORK_LARGE + 1], slot / STP_ROW + 1);
}
#endif

void main()
{
    uint id = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex;
#ifdef LISTED
    if (id >= frame.work.v[STP_WORK_REPAIR + 3])
        return;
    id = frame.large.v[frame.splat_count + id];
#else
    if (id >= frame.splat_count)
        return;
#endif
    Splat s;
    if (!splat_load(id, s) || (!ORTHOGRAPHIC && splat_before_near(s)))
        return;
    bool floored;
    Footprint f = footprint_make(s, floored);
    ivec4 box = footprint_pixels(s, f, floored);
    int width = box.z - box.x + 1, height = box.w - box.y + 1;
    bool large = !bounds_small(s, floored, box);
    int count = large ? 0 : width * height;
#ifdef FIRST_PASS
    if (large)
        defer_large(id);
    if (count > 0)
        touch_blocks(box);
#endif
    uint encoded = splat_encode(id, s);
    int x = box.x, y = box.y;
    for (int i = 0; i < count; i++) {
        visit(id, s, f, false, encoded, uvec2(x, y));
        if (++x > box.z) {
            x = box.x;
            y++;
        }
    }
}

#endif

#endif
