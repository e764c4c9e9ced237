#version 460
#extension GL_GOOGLE_include_directive : require
// Three vertices a kernel: a triangle around its outline on the screen. Fragments decide exactly, so
// this only has to be wide enough.
#include "lib/common.glsl"
#include "lib/clip.glsl"
#include "lib/axis.glsl"
#include "lib/ellipsoid.glsl"

layout(location = 0) flat out vec4 vary_place; // centre, tau
layout(location = 1) flat out vec4 vary_color; // and the tile's first column
layout(location = 2) flat out vec4 vary_r;     // the factor; and the tile's first row
layout(location = 3) flat out vec3 vary_s;
layout(location = 4) flat out vec4 vary_lens; // the picture's centre, and what a pixel is of a ray

const float WIDE = 2.02; // an equilateral triangle of inradius 1 reaches 2
const float NEAR = 0.2;  // reach over least depth, up to which the outline is nearly an ellipse

// Around the ellipse of the centre's ray, wider by what perspective can bend it.
vec2 around_ellipse(vec3 c, vec3 form, uint corner, float bend)
{
    vec2 focal = vec2(frame.focal[0], frame.focal[1]), middle = vec2(frame.center[0], frame.center[1]);
    float z = ORTHOGRAPHIC ? 1 : c.z;
    vec2 at = middle + focal * c.xy / z;
    float xx = form.x, xy = form.y, yy = form.z;
    vec2 u = vec2(corner == 0 ? 1.0 : -0.5, corner == 0 ? 0 : corner == 1 ? 0.8660254 : -0.8660254);
    u *= WIDE * float(STP_AXIS_REACH) * (1 + 2 * bend) / z;
    float l11 = sqrt(xx), l21 = xy / l11, l22 = sqrt(max(yy - l21 * l21, 1e-6 * yy));
    vec2 d;
    d.y = u.y / l22;
    d.x = (u.x - l21 * d.y) / l11;
    return at + focal * d;
}

// Around the rectangle of what the kernel's box can cover, kept near the tile.
vec2 around_box(vec3 c, vec3 h, uint corner)
{
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

// A voxel's kernel has the factor that all have.
Ellipsoid load_kernel(uint id, out vec3 color, out bool known)
{
    vec4 place = frame.projected.v[2 * id], look = frame.projected.v[2 * id + 1];
    const float f[6] = frame.axis.factor, h[3] = frame.axis.extent;
    color = look.xyz;
    known = look.w > 0;
    return Ellipsoid(place.xyz, exp2(place.w) * frame.axis.scale * (1 / SQRT_2_PI),
                     vec3(f[0], f[1], f[2]), vec3(f[3], f[4], f[5]), vec3(h[0], h[1], h[2]));
}

void main()
{
    uint id = frame.order.v[push_first + gl_VertexIndex / 3], corner = gl_VertexIndex % 3;
    Ellipsoid e;
    vec3 color;
    bool known;
    if (ELLIPSOIDS) {
        e = ellipsoid_load(id, color);
        known = e.extent.x > 0;
    } else {
        e = load_kernel(id, color, known);
    }
    vec3 h = e.extent;
    float least = e.centre.z - h.z, bend = max(h.x, max(h.y, h.z)) / max(least, 1e-30);
    bool simple = ORTHOGRAPHIC || (least > frame.near_depth && bend < NEAR);
    vec2 place = simple ? around_ellipse(e.centre, ellipsoid_form(e), corner, ORTHOGRAPHIC ? 0 : bend)
                        : around_box(e.centre, h, corner);
    gl_Position = known ? to_clip(place, 0.5, 1) : NO_VERTEX;
    vary_place = vec4(e.centre, e.tau);
    vary_color = vec4(color, frame.tile_x);
    vary_r = vec4(e.r, frame.tile_y);
    vary_s = e.s;
    vary_lens = vec4(frame.center[0], frame.center[1], frame.inv_focal[0], frame.inv_focal[1]);
}
