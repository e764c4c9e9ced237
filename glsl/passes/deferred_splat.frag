#version 460
#extension GL_GOOGLE_include_directive : require
// ZP Algorithm 1, geometry pass, by the rasteriser: the winner's id and depth, or its packed key; Eq. 10 as
// the depth.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define FRAGMENT
#include "lib/varying.glsl"

#ifdef WITH_KEY
#include "lib/key.glsl"
#endif

layout(location = 0) out uvec2 winner;

void main()
{
    Fragment f = fragment_here();
#if defined(WITH_KEY) && defined(WITH_PHONG)
    winner = key_words(f, normal_encode(normal_here(f)));
#elif defined(WITH_KEY)
    winner = key_words(f, vary_encoded);
#else
    winner = uvec2(vary_id, floatBitsToUint(f.depth));
#endif
    gl_FragDepth = hardware_depth(f.depth);
    if (VORONOI == 1) {
        float slab = floor((f.depth - frame.depth_low) * frame.slab_scale);
        gl_FragDepth =
            clamp(1 - (slab + 0.999 * min(sqrt(f.rho2), 1)) * frame.raster_slab, 0, 1);
    }
}
