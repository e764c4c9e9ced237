#version 460
#extension GL_GOOGLE_include_directive : require
// Large splats to lists of the blocks that they may touch, and what each is on the screen to a record:
// once a frame, whatever draws them. A few threads a splat. A splat that the near plane cuts, or for
// which records or entries are used up, is left to the workgroup that draws it alone.
#include "lib/common.glsl"
#define SAME_BITS
#include "lib/splat.glsl"
#include "lib/record.glsl"
layout(local_size_x = STP_BIN_GROUP) in;

const uint NONE = ~0u;
const uint PER = STP_BLOCK; // blocks that a workgroup of lib/binned.glsl takes

shared uint shared_first;

// Of the splat's entries; NONE: it gets none.
uint reserve(uint record, uint count)
{
    uint most = frame.blocks_x * frame.blocks_y * min(STP_BIN_ENTRIES, frame.splat_count);
    if (gl_LocalInvocationIndex == 0) {
        shared_first = NONE;
        if (count > 0 && record < STP_BIN_SPLATS)
            shared_first = atomicAdd(frame.work.v[STP_WORK_ENTRIES], count);
    }
    barrier();
    return shared_first <= most && count <= most - shared_first ? shared_first : NONE;
}

void leave(uint id)
{
    uint slot = atomicAdd(frame.work.v[STP_WORK_REST + 3], 1);
    frame.bins.v[slot] = id;
    atomicMax(frame.work.v[STP_WORK_REST], min(slot + 1, STP_ROW));
    atomicMax(frame.work.v[STP_WORK_REST + 1], slot / STP_ROW + 1);
}

// Least square of a distance from the origin to the side from p along d.
float side_distance2(vec2 p, vec2 d)
{
    vec2 q = p + clamp(-dot(p, d) / dot(d, d), 0, 1) * d;
    return dot(q, q);
}

// Whether the ellipse may reach into the block: where it is a circle around the origin, the block is
// a parallelogram, and the circle is as large as den is at most there. Rounding, and what is no
// number, keep it. middle: from the projected centre.
bool reaches(Footprint f, vec2 middle)
{
    const float half_ = 0.5 * STP_BLOCK;
    vec2 x = vec2(sqrt(f.q.x), 0), y = vec2(x.x * f.q.y, sqrt(f.q.z)), c = middle.x * x + middle.y * y;
    float most = abs(f.g + dot(f.ab, middle)) + half_ * (abs(f.ab.x) + abs(f.ab.y));
    x *= half_;
    y *= half_;
    float side = min(min(side_distance2(c - x - y, 2 * x), side_distance2(c - x + y, 2 * x)),
                     min(side_distance2(c - x - y, 2 * y), side_distance2(c + x - y, 2 * y)));
    float slack = 1e-3 * most + 1e-5 * (length(c) + length(x) + length(y));
    bool inside = all(lessThanEqual(abs(middle), vec2(half_)));
    return inside || !(sqrt(side) > most + slack);
}

// entry: counted from 1.
void push(uint block, uint entry, uint record)
{
    uint count = frame.blocks_x * frame.blocks_y, at = frame.splat_count + 2 * (entry - 1);
    uint next = atomicExchange(frame.work.v[STP_WORK_FLAGS + 2 * count + block], entry);
    frame.bins.v[at] = record;
    frame.bins.v[at + 1] = next;
    if (next != 0)
        return;
    uint slot = atomicAdd(frame.work.v[STP_WORK_BINNED + 3], 1), group = slot / PER;
    frame.work.v[STP_WORK_FLAGS + block] = STP_BLOCK_TOUCHED;
    frame.work.v[STP_WORK_FLAGS + 3 * count + slot] = block;
    atomicMax(frame.work.v[STP_WORK_BINNED], min(group + 1, STP_ROW));
    atomicMax(frame.work.v[STP_WORK_BINNED + 1], group / STP_ROW + 1);
}

void main()
{
    uint record = gl_WorkGroupID.y * STP_ROW + gl_WorkGroupID.x;
    bool known = record < frame.work.v[STP_WORK_LARGE + 3], floored;
    uint id = known ? frame.large.v[record] : 0;
    Splat s;
    splat_load(id, s);
    Footprint f = footprint_make(s, floored);
    bool clipped = splat_clipped(s, floored);
    ivec2 corner = ivec2(frame.tile_x, frame.tile_y);
    ivec4 box = clipped ? ivec4(0, 0, -1, -1) : footprint_pixels(s, f, floored);
    bool any = known && box.z >= box.x;
    uvec4 b = any ? uvec4(box - corner.xyxy) / STP_BLOCK : uvec4(0);
    uint width = b.z - b.x + 1, count = any ? width * (b.w - b.y + 1) : 0;
    uint first = reserve(record, count);
    if (first == NONE || count == 0) {
        if (known && gl_LocalInvocationIndex == 0)
            leave(id);
        return;
    }
    if (gl_LocalInvocationIndex == 0)
        record_store(record, id, s, f);
    for (uint i = gl_LocalInvocationIndex; i < count; i += STP_BIN_GROUP) {
        uvec2 block = uvec2(b.x + i % width, b.y + i / width);
        vec2 middle = vec2(ivec2(block) * STP_BLOCK + corner - f.p.whole) + (0.5 * STP_BLOCK - f.p.part);
        if (reaches(f, middle))
            push(block.y * frame.blocks_x + block.x, first + i + 1, record);
    }
}
