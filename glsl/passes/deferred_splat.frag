#version 460
#extension GL_GOOGLE_include_directive : require
// ZP Algorithm 1, geometry pass, by the rasteriser: the winner's id; Eq. 10 as the depth.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define FRAGMENT
#include "lib/varying.glsl"

layout(location = 0) out uint id;

void main()
{
    Fragment f = fragment_here();
    id = vary_id;
    gl_FragDepth = hardware_depth(f.depth);
    if (VORONOI == 1) {
        float slab = floor((f.depth - frame.depth_low) * frame.slab_scale);
        float slabs = ceil(frame.slab_scale / frame.raster_scale) + 1;
        gl_FragDepth = clamp(1 - (slab + 0.999 * min(sqrt(f.rho2), 1)) / slabs, 0, 1);
    }
}
