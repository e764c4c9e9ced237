#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.2: a texel of level push_first from four of the level below: the mean of those whose depth
// interval meets that of the frontmost.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
layout(local_size_x_id = PLAN_LANES) in;

// Neither near nor far cuts the disc.
bool disc_uncut(Texel t)
{
    return t.depth - t.radius >= frame.near_depth && t.depth + t.radius <= frame.far_depth;
}

void pull(uint level, ivec2 p)
{
    ivec2 first = 2 * (p + level_origin(level)) - level_origin(level - 1);
    Texel child[4], mean = EMPTY;
    float front = NOTHING, reach = NOTHING, count = 0, full = 0;
    Attributes a = Attributes(vec3(0), STP_NO_ID, 0), frontmost = a;
    for (int i = 0; i < 4; i++)
        child[i] = texel_load(level - 1, first + ivec2(i & 1, i >> 1));
    [[unroll]] for (int i = 0; i < 4; i++) {
        bool nearer = child[i].depth - child[i].extent < front;
        front = nearer ? child[i].depth - child[i].extent : front;
        reach = nearer ? child[i].depth + child[i].extent + child[i].radius : reach;
    }
    [[unroll]] for (int i = 0; i < 4; i++) {
        bool counts = texel_valid(child[i]) && child[i].depth - child[i].extent <= reach;
        float w = counts ? 1 : 0;
        count += w;
        full += child[i].full ? w : 0;
        mean.exact = mean.exact || (counts && child[i].exact && (level > 1 || disc_uncut(child[i])));
        mean.depth += counts ? child[i].depth : 0;
        mean.radius += w * child[i].radius;
        mean.normal += w * child[i].normal;
        mean.center += w * child[i].center;
#if ATTRIBUTES > 0
        Attributes of = attributes_load(level - 1, first + ivec2(i & 1, i >> 1));
        a.color += counts ? of.color : vec3(0);
        if (counts && child[i].depth - child[i].extent == front)
            frontmost = of;
#endif
    }
    float scale = 1 / count;
    mean.depth *= scale;
    mean.exact = mean.exact && count == 1;
    mean.full = full >= (level == 1 ? 2 : 3);
    mean.radius *= scale;
    mean.center *= scale;
    [[unroll]] for (int i = 0; i < 4; i++) {
        bool counts = texel_valid(child[i]) && child[i].depth - child[i].extent <= reach;
        float nearest = child[i].depth - child[i].extent;
        float farthest = child[i].depth + child[i].extent + child[i].radius;
        if (counts)
            mean.extent = max(mean.extent, max(mean.depth - nearest, farthest - mean.depth - mean.radius));
        if (counts && !(dot(mean.normal, mean.normal) > 1e-12) && nearest == front)
            mean.normal = child[i].normal;
    }
    if (!(count > 0)) // the level starts empty
        return;
    texel_store(level, p, mean);
    attributes_store(level, p, Attributes(a.color * scale, frontmost.id, frontmost.object));
}

// Of level 1: some point fell into the block of the picture that the texel lies in.
bool below(uvec2 p)
{
    uvec2 block = p / (STP_BLOCK / 2);
    return push_first != 1 || frame.work.v[STP_WORK_FLAGS + block.y * (frame.grid_width / STP_BLOCK) + block.x] != 0;
}

// A thread's texels up to the next that may have something below it.
void main()
{
    uvec2 size = level_size(push_first);
    uint block = workgroup_index(), columns = (size.x + STP_BLOCK - 1) / STP_BLOCK;
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP;) {
        bool found = false;
        uvec2 p = corner;
        for (; i < STP_GROUP && !found; i += gl_WorkGroupSize.x) {
            p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
            found = all(lessThan(p, size)) && below(min(p, size - 1)); // loads are not always masked
        }
        if (found)
            pull(push_first, ivec2(p));
    }
}
