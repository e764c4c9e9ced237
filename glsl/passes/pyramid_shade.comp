#version 460
#extension GL_GOOGLE_include_directive : require
// MKC 3.3 for level 0, and 3.4: the picture's pixels, shaded as those of every method are.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/pyramid.glsl"
#include "lib/push.glsl"
#define SURFACE_OBJECT(s) surface_object
uint surface_object;
#include "lib/shade.glsl"
#include "lib/own.glsl"
layout(local_size_x_id = 22) in;

void shade_pixel(uint block, ivec2 p, uvec2 pixel)
{
    vec2 q = vec2(p + ivec2(frame.grid_x, frame.grid_y)) +
             (sample_part(pixel + uvec2(frame.tile_x, frame.tile_y)) - sample_shift());
    Texel own = texel_load(0, p);
    bool valid = texel_valid(own);
    Pushed r = push_from(1, p, q, valid);
    Surface s = own_surface(own, q, p);
    bool copied = valid && !(r.weight > 0 && s.depth > r.reach);
    if (!copied) {
        s = Surface(r.weight, r.normal, r.depth, r.attributes.color, r.disc.normal, r.depth,
                    r.attributes.id, r.count);
        surface_object = r.attributes.object;
    }
    s.albedo /= frame.pyramid_color;
    // A mean's plane may reach beyond near and far, its disc beyond the union of its points'.
    bool hit = copied || (r.weight > 0 && !(r.disc.rim && !valid) && r.depth >= frame.near_depth &&
                          r.depth <= frame.far_depth);
    // What lies behind a texel whose mean disc misses it may be hidden by the points' own discs.
    bool doubtful = copied && s.depth > r.before;
    if (!doubtful || SAMPLE_GRID == 1)
        surface_write(pixel, hit, s);
    if (hit && !doubtful)
        return;
    // Points round about may reach here yet: the passes over the rim see to it.
    uint slot = atomicAdd(frame.work.v[STP_WORK_EMPTY + 3], 1);
    frame.rim.v[slot] = uint(p.y) * frame.grid_width + uint(p.x);
    if (slot % STP_GROUP == 0)
        count_groups(STP_WORK_EMPTY, slot / STP_GROUP + 1);
    if (doubtful)
        return;
    frame.keys.v[grid_index(uvec2(p))] = packUint2x32(uvec2(STP_RIM_NONE, STP_RIM_DEPTH));
    frame.work.v[STP_WORK_FLAGS + block] = STP_BLOCK_TOUCHED;
}

void main()
{
    uint index = workgroup_index(), columns = frame.grid_width / STP_BLOCK;
    if (index >= frame.work.v[STP_WORK_BLOCKS + 3])
        return;
    uint block = touched_block(index);
    ivec2 corner = ivec2(block % columns, block / columns) * STP_BLOCK;
    ivec2 tile = ivec2(frame.tile_x, frame.tile_y) - ivec2(frame.grid_x, frame.grid_y);
    for (uint i = gl_LocalInvocationIndex; i < STP_GROUP; i += gl_WorkGroupSize.x) {
        ivec2 p = corner + ivec2(i % STP_BLOCK, i / STP_BLOCK), pixel = p - tile;
        if (all(greaterThanEqual(pixel, ivec2(0))) &&
            all(lessThan(pixel, ivec2(frame.tile_width, frame.tile_height))))
            shade_pixel(block, p, uvec2(pixel));
    }
}
