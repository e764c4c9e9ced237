// What resolving passes share: a workgroup a touched block, and fragments fetched again by id.
// IN_ROWS: what follows another in the rows of the tile is a block, STP_GROUP pixels, as images and the
// picture lie in memory; eight rows at once are as many places that a CPU does not foresee, and take twice
// the time (docs/deferred.md). ALL_BLOCKS: also the untouched.
#include "lib/pixel.glsl"
layout(local_size_x = STP_GROUP) in;

bool resolve_pixel(out uvec2 p, out uint pixel)
{
    uint count = frame.blocks_x * frame.blocks_y;
#ifdef ALL_BLOCKS
    uint block = workgroup_index();
    if (block >= count)
        return false;
#else
    uint index = workgroup_index();
    if (index >= frame.work.v[STP_WORK_BLOCKS + 3])
        return false;
    uint block = frame.work.v[STP_WORK_FLAGS + count + index];
#endif
    pixel = block * STP_GROUP + gl_LocalInvocationIndex;
#ifdef IN_ROWS
    p = uvec2(pixel % frame.tile_width, pixel / frame.tile_width);
    return p.y < frame.tile_height;
#else
    return block_pixel(block, gl_LocalInvocationIndex, p);
#endif
}

// The fragment that splat `id` had at this pixel of the tile, by the same arithmetic.
Fragment fragment_again(uint id, uvec2 pixel, out Splat s)
{
    splat_load(id, s);
    bool floored;
    Footprint f = footprint_make(s, floored);
    Fragment fragment;
    uvec2 at = pixel + uvec2(frame.tile_x, frame.tile_y);
    if (splat_clipped(s, floored))
        clipped_hit(s, at, fragment);
    else
        footprint_hit(f, s.phong, place_offset(f.p, at), fragment);
    return fragment;
}

// The normal of that fragment.
vec3 normal_again(uint id, uvec2 pixel)
{
    Splat s;
    if (PHONG == 0) {
        splat_load(id, s);
        return s.normal;
    }
    Fragment f = fragment_again(id, pixel, s);
    return fragment_normal(s, f);
}
