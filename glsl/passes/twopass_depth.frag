#version 460
#extension GL_GOOGLE_include_directive : require
// Visibility splatting: the nearest depth and its splat. PEEL: behind the layers that are peeled.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define FRAGMENT
#include "lib/varying.glsl"

layout(location = 0) out uvec2 nearest;

void main()
{
    Fragment f = fragment_here();
#ifdef PEEL
    // Something opaque belongs to no transparent layer: it is not peeled with one.
    uvec2 p = uvec2(gl_FragCoord.xy);
    bool opaque = MIXED && splat_opaque(vary_id);
    if (!opaque && f.depth <= uintBitsToFloat(frame.nearest.v[p.y * frame.tile_width + p.x]))
        discard;
#endif
    nearest = uvec2(floatBitsToUint(f.depth), vary_id);
    gl_FragDepth = hardware_depth(f.depth);
}
