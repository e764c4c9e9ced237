#ifndef PROJECTED_GLSL
#define PROJECTED_GLSL
// What axis_project and axis_surface leave of a splat, and the blocks' lists of splats. FETCHED: as
// texels, which a software device gathers for all lanes at once, where addresses go one by one.
#ifdef FETCHED
layout(set = 0, binding = STP_BINDING_PROJECTED) uniform utextureBuffer projected_texels;
layout(set = 0, binding = STP_BINDING_ORDER) uniform utextureBuffer order_texels;
#endif

vec4 projected_at(uint at)
{
#ifdef FETCHED
    return uintBitsToFloat(texelFetch(projected_texels, int(at)));
#else
    return frame.projected.v[at];
#endif
}

uint order_at(uint at)
{
#ifdef FETCHED
    return texelFetch(order_texels, int(at)).x;
#else
    return frame.order.v[at];
#endif
}
#endif
