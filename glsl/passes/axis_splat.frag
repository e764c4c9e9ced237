#version 460
#extension GL_GOOGLE_include_directive : require
// One kernel's premultiplied colour and depth; blended over what lies behind, in primitive order.
#include "lib/common.glsl"
#include "lib/axis.glsl"
#include "lib/ellipsoid.glsl"

// As of lib/varying.glsl: what is flat is broadcast, a constant of the frame block is gathered.
layout(location = 0) flat in vec4 vary_place;
layout(location = 1) flat in vec4 vary_color; // and the tile's first column
layout(location = 2) flat in vec4 vary_r;     // and its first row
layout(location = 3) flat in vec3 vary_s;
layout(location = 4) flat in vec4 vary_lens;
layout(location = 0) out vec4 color;
layout(location = 1) out vec4 depth_sum; // alpha depth; the image has no alpha, blending takes this

void main()
{
    float depth;
    vec2 pixel = gl_FragCoord.xy + vec2(vary_color.w, vary_r.w);
    Ellipsoid e = Ellipsoid(vary_place.xyz, vary_place.w, vary_r.xyz, vary_s, vec3(0));
    float alpha = ellipsoid_alpha(e, (pixel - vary_lens.xy) * vary_lens.zw, depth);
    color = vec4(alpha * vary_color.xyz, alpha);
    depth_sum = vec4(alpha * depth, 0, 0, alpha);
}
