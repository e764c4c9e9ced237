#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.2: a texel of level push_first from four of the level below: the mean of those whose depth
// interval meets that of the frontmost.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
layout(local_size_x_id = 22) in;

void pull(uint level, ivec2 p)
{
    ivec2 first = 2 * (p + level_origin(level)) - level_origin(level - 1);
    Texel child[4], mean = Texel(0, 0, 0, vec3(0), vec2(0), false, false);
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
    mean.depth = count > 0 ? mean.depth * scale : NOTHING;
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
    texel_store(level, p, mean);
    if (count > 0)
        attributes_store(level, p, Attributes(a.color * scale, frontmost.id, frontmost.object));
}

void main()
{
    uvec2 size = level_size(push_first);
    uint block = workgroup_index(), columns = (size.x + STP_BLOCK - 1) / STP_BLOCK;
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP; i += gl_WorkGroupSize.x) {
        uvec2 p = corner + uvec2(i % STP_BLOCK, i / STP_BLOCK);
        if (all(lessThan(p, size)))
            pull(push_first, ivec2(p));
    }
}
