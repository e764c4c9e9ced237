#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.1: the attributes of the points that won their pixels become level 0. Of points that stream in
// chunks, those of this chunk; what earlier ones left stays.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
layout(local_size_x_id = 22) in;
layout(set = 0, binding = STP_BINDING_RADII) uniform samplerBuffer point_radii;

void gather(uvec2 p, uint id)
{
    bool found = id - push_first < push_count;
    uint index = found ? id - push_first : 0;
    Splat s;
    uvec2 pixel;
    vec2 offset;
    point_load(index, s);
    point_pixel(s, pixel, offset);
    Texel t;
    t.depth = found ? s.center.z : NOTHING;
    t.extent = 0;
    t.radius = texelFetch(point_radii, int(index)).x;
    t.normal = s.normal;
    t.center = level_middle(0, ivec2(p)) + offset;
    t.full = true;
    if (!found && id != STP_NO_POINT)
        return;
    texel_store(0, ivec2(p), t);
#if ATTRIBUTES > 0
    if (!found)
        return;
    Attributes a = Attributes(vec3(0), id, 0);
    if (HAS_COLOR)
        a.color = frame.colors.v[index] * frame.pyramid_color;
    if (HAS_OBJECTS)
        a.object = frame.objects.v[index];
    attributes_store(0, ivec2(p), a);
#endif
}

void main()
{
    uint block = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (block >= columns * (frame.grid_height / STP_BLOCK))
        return;
    uvec2 corner = uvec2(block % columns, block / columns) * STP_BLOCK;
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP; i += gl_WorkGroupSize.x) {
        uint id = UintRef(uint64_t(frame.keys)).v[2 * (block * STP_GROUP + i)];
        gather(corner + uvec2(i % STP_BLOCK, i / STP_BLOCK), id);
    }
}
