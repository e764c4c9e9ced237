#version 460
#extension GL_GOOGLE_include_directive : require
// The host's depth, as it was copied, to the eye depth that ends each pixel's ray: +Inf where the
// host drew nothing, 0 outside of its image.
#include "lib/host.glsl"
#include "lib/pixel.glsl"
layout(local_size_x = STP_GROUP) in;

float limit(ivec2 at)
{
    if (any(lessThan(at, push_low)) || any(greaterThanEqual(at, push_high)))
        return 0;
    float d = host_depth(at);
    if (d == push_none)
        return 1.0 / 0.0;
    return ORTHOGRAPHIC ? (d - push_add) / push_scale : push_scale / (d - push_add);
}

void main()
{
    uvec2 p;
    uint block = workgroup_index();
    if (block >= frame.blocks_x * frame.blocks_y ||
        !block_pixel(block, gl_LocalInvocationIndex, p))
        return;
    frame.limits.v[block * STP_GROUP + gl_LocalInvocationIndex] =
        floatBitsToUint(limit(ivec2(p) + ivec2(frame.tile_x, frame.tile_y) + push_corner));
}
