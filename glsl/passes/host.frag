#version 460
#extension GL_GOOGLE_include_directive : require
// The finished tile into the host's colour, and, with WITH_DEPTH, its depth. Layers were cut by that
// depth when they were made: it is then not tested, and stays where nothing opaque ends the ray.
#include "lib/host.glsl"

layout(location = 0) out vec4 color;

void main()
{
    uvec2 p = uvec2(ivec2(gl_FragCoord.xy) - push_corner) - uvec2(frame.tile_x, frame.tile_y);
    uint at = p.y * frame.tile_width + p.x;
    float z = frame.out_depth.v[at];
    bool none = isinf(z);
    vec4 c = frame.out_color.v[at];
    if (none && c.w == 0 && push_replace == 0)
        discard;
    color = min(c, vec4(push_most));
#ifdef WITH_DEPTH
    float d = push_add + push_scale * (ORTHOGRAPHIC ? z : 1 / z);
    gl_FragDepth = none ? push_none : clamp(d, 0, 1);
    if (HOST_DEPTH != 0 && none)
        gl_FragDepth = host_depth(ivec2(gl_FragCoord.xy));
#endif
}
