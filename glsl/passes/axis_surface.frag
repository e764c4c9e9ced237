#version 460
#extension GL_GOOGLE_include_directive : require
// One surface splat's premultiplied colour and depth; blended over what lies behind, in primitive
// order.
#include "lib/common.glsl"
#include "lib/gaussian.glsl"

layout(location = 0) flat in vec4 vary_head;
layout(location = 1) flat in vec4 vary_s;
layout(location = 2) flat in vec4 vary_t;
layout(location = 3) flat in vec4 vary_v;
layout(location = 4) flat in vec4 vary_clip[2];
layout(location = 0) out vec4 color;
layout(location = 1) out vec4 depth_sum; // alpha depth; the image has no alpha, blending takes this

void main()
{
    GaussianWords w;
    w.head = vary_head;
    w.s = vary_s;
    w.t = vary_t;
    w.v = vary_v;
    w.clip = vary_clip;
    float depth;
    vec2 pixel = vec2(uvec2(gl_FragCoord.xy) + uvec2(frame.tile_x, frame.tile_y));
    float alpha = gaussian_alpha(w, pixel, depth);
    color = vec4(alpha * gaussian_color(w), alpha);
    depth_sum = vec4(alpha > 0 ? alpha * depth : 0, 0, 0, alpha);
}
