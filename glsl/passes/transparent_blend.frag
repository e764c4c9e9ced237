#version 460
#extension GL_GOOGLE_include_directive : require
// ZP Algorithm 2, geometry pass: a fragment blended over what lies behind it. The depth test lets
// one fragment of a slab pass (Eq. 6), the first to come. OTHERS: Algorithm 3, second pass, without
// the nearest layer.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define GRAPHICS
#include "lib/pixel.glsl"
#include "lib/shade.glsl"
#define FRAGMENT
#define BLENDED
#include "lib/varying.glsl"
#include "lib/transparent.glsl"

#ifdef OTHERS
layout(location = 0) out vec4 blended;
#else
layout(location = 0) out uvec2 nearest;
layout(location = 1) out vec4 blended;
#endif

// Hardware depth of the fragment's slab (see slabs_of). An opaque fragment wins its slab. Where objects
// have epsilons of their own so have the slabs, which are compared by where they end, in least epsilons:
// what is nearer by its own epsilon passes.
float slab_depth(float depth, bool opaque)
{
    float at = floor(vary_slabs.x + (depth - vary_a.z) * vary_slabs.y), unit = vary_slabs.w;
    if (HAS_OBJECTS)
        at = min((at + 1) * vary_thick, 1 / unit - 1) - 1;
    return clamp(1 - (at - (opaque ? 0.5 : 0.0)) * unit, 0, 1);
}

void main()
{
    Fragment f = fragment_here();
    uvec2 p = uvec2(gl_FragCoord.xy);
    bool opaque = MIXED && vary_color.w == 1;
#ifdef OTHERS
    // Something opaque ends the ray wherever it is: it belongs to no transparent layer.
    if (!opaque && f.depth <= uintBitsToFloat(frame.nearest.v[p.y * frame.tile_width + p.x]))
        discard;
#else
    uint adds = vary_encoded | uint(min(f.rho2 * vary_rho_scale, WINNER_RHO) + 0.5);
    nearest = uvec2(PACKED ? adds : vary_id, floatBitsToUint(f.depth));
#endif
    vec3 color = vary_color.xyz;
    if (!SHADED_ONCE)
        color = shade(splat_material(vary_id), color, vary_normal, pixel_position(p), f.depth);
    if ((OPTICS & STP_OPTICS_SURFACE) != 0 && opaque)
        color = surface_mirrors(frame.optics.v[splat_object(vary_id)], color, vary_normal,
                                ray_direction(pixel_position(p)));
    blended = vec4(color * vary_color.w, vary_color.w);
    gl_FragDepth = slab_depth(f.depth, opaque);
}
