#version 460
#extension GL_GOOGLE_include_directive : require
// Visibility splatting: the nearest depth and its splat.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define FRAGMENT
#include "lib/varying.glsl"

layout(location = 0) out uvec2 nearest;

void main()
{
    Fragment f = fragment_here();
    nearest = uvec2(floatBitsToUint(f.depth), vary_id);
    gl_FragDepth = hardware_depth(f.depth);
}
