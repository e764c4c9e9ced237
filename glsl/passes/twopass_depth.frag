#version 460
#extension GL_GOOGLE_include_directive : require
// Visibility splatting: the nearest depth and its splat. Of a transparent scene, behind the layers
// that are peeled.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/peel.glsl"
#define FRAGMENT
#include "lib/varying.glsl"

layout(location = 0) out uvec2 nearest;

void main()
{
    Fragment f = fragment_here();
    uvec2 p = uvec2(gl_FragCoord.xy);
    if (peeled(p.y * frame.tile_width + p.x, vary_id, f.depth))
        discard;
    nearest = uvec2(floatBitsToUint(f.depth), vary_id);
    gl_FragDepth = hardware_depth(f.depth);
}
