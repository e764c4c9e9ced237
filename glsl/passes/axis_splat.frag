#version 460
#extension GL_GOOGLE_include_directive : require
// One kernel's premultiplied colour and depth; blended over what lies behind, in primitive order.
#include "lib/common.glsl"
#include "lib/axis.glsl"
#include "lib/ellipsoid.glsl"

layout(location = 0) flat in vec4 vary_place;
layout(location = 1) flat in vec3 vary_color;
layout(location = 2) flat in vec3 vary_r; // ellipsoids: their factor
layout(location = 3) flat in vec3 vary_s;
layout(location = 0) out vec4 color;
layout(location = 1) out vec4 depth_sum; // alpha depth; the image has no alpha, blending takes this

void main()
{
    float depth;
    Ray r = axis_ray(gl_FragCoord.xy + vec2(frame.tile_x, frame.tile_y));
    Ellipsoid e = Ellipsoid(vary_place.xyz, vary_place.w, vary_r, vary_s, vec3(0));
    float alpha = ELLIPSOIDS ? ellipsoid_alpha(e, r.d, depth)
                             : axis_alpha(r, vary_place.xyz, vary_place.w, depth);
    color = vec4(alpha * vary_color, alpha);
    depth_sum = vec4(alpha * depth, 0, 0, alpha);
}
