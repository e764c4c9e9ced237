#version 460
#extension GL_GOOGLE_include_directive : require
// Three vertices a kernel: a triangle around its outline on the screen. Fragments decide exactly, so
// this only has to be wide enough.
#include "lib/common.glsl"
#include "lib/axis.glsl"

layout(location = 0) flat out vec4 vary_place; // centre, log2 of tau
layout(location = 1) flat out vec3 vary_color;

const float WIDE = 2.02; // an equilateral triangle of inradius 1 reaches 2
const float NEAR = 0.2;  // reach over least depth, up to which the outline is nearly an ellipse

vec4 to_clip(vec2 pixel)
{
    vec2 size = vec2(frame.tile_width, frame.tile_height);
    return vec4((pixel - vec2(frame.tile_x, frame.tile_y)) * 2 / size - 1, 0.5, 1);
}

// Around the ellipse of the centre's ray, wider by what perspective can bend it.
vec2 around_ellipse(vec3 c, uint corner, float bend)
{
    vec2 focal = vec2(frame.focal[0], frame.focal[1]), middle = vec2(frame.center[0], frame.center[1]);
    float z = ORTHOGRAPHIC ? 1 : c.z;
    vec2 at = middle + focal * c.xy / z;
    Ray r = axis_ray(at);
    float turn = -2 / LOG2_E; // the form is of an exponent
    float xx = turn * r.form.x, xy = 0.5 * turn * r.form.y, yy = turn * r.form.z;
    vec2 u = vec2(corner == 0 ? 1.0 : -0.5, corner == 0 ? 0 : corner == 1 ? 0.8660254 : -0.8660254);
    u *= WIDE * sqrt(frame.axis.reach2) * (1 + 2 * bend) / z;
    float l11 = sqrt(xx), l21 = xy / l11, l22 = sqrt(max(yy - l21 * l21, 1e-6 * yy));
    vec2 d;
    d.y = u.y / l22;
    d.x = (u.x - l21 * d.y) / l11;
    return at + focal * d;
}

// Around the rectangle of what the kernel's box can cover, kept near the tile.
vec2 around_box(vec3 c, uint corner)
{
    vec3 h = vec3(frame.axis.extent[0], frame.axis.extent[1], frame.axis.extent[2]);
    vec2 low = c.xy - h.xy, high = c.xy + h.xy;
    float near = max(c.z - h.z, frame.near_depth), far = max(c.z + h.z, near);
    if (!ORTHOGRAPHIC) {
        low /= vec2(low.x < 0 ? near : far, low.y < 0 ? near : far);
        high /= vec2(high.x > 0 ? near : far, high.y > 0 ? near : far);
    }
    vec2 focal = vec2(frame.focal[0], frame.focal[1]), middle = vec2(frame.center[0], frame.center[1]);
    vec2 tile = vec2(frame.tile_x, frame.tile_y), size = vec2(frame.tile_width, frame.tile_height);
    low = clamp(middle + focal * low - 1, tile - 1, tile + size + 1);
    high = clamp(middle + focal * high + 1, tile - 1, tile + size + 1);
    return low + vec2(corner == 1 ? 2 : 0, corner == 2 ? 2 : 0) * (high - low);
}

void main()
{
    uint id = frame.order.v[push_first + gl_VertexIndex / 3], corner = gl_VertexIndex % 3;
    vec4 place = frame.projected.v[2 * id];
    vec3 h = vec3(frame.axis.extent[0], frame.axis.extent[1], frame.axis.extent[2]);
    float least = place.z - h.z, bend = max(h.x, max(h.y, h.z)) / max(least, 1e-30);
    bool simple = ORTHOGRAPHIC || (least > frame.near_depth && bend < NEAR);
    gl_Position = to_clip(simple ? around_ellipse(place.xyz, corner, ORTHOGRAPHIC ? 0 : bend)
                                 : around_box(place.xyz, corner));
    vary_place = place;
    vary_color = frame.projected.v[2 * id + 1].xyz;
}
