#version 460
#extension GL_GOOGLE_include_directive : require
// Three vertices a surface splat: a triangle around its outline on the screen. Fragments decide
// exactly, so this only has to be wide enough.
#include "lib/common.glsl"
#include "lib/clip.glsl"
#include "lib/gaussian.glsl"

layout(location = 0) flat out vec4 vary_head;
layout(location = 1) flat out vec4 vary_s;
layout(location = 2) flat out vec4 vary_t;
layout(location = 3) flat out vec4 vary_v;
layout(location = 4) flat out vec4 vary_clip[2];

const float WIDE = 2.02;    // an equilateral triangle of inradius 1 reaches 2
const float BEND = 0.2;     // of v over the outline, up to which it is nearly an ellipse
const float SLACK = 0.0625; // pixels: vertices are snapped to 1/256 of one
const float LOSS = 1e-6;    // of what determinants of floats lose, relative to their terms

// The outline is s^2 + t^2 = v^2. Of (x, y, 1) = K (cos, sin, 1) v, K the inverse of the rows, tangents
// across: bounds of x and y; false where it is no ellipse.
bool conic_bounds(vec3 s, vec3 t, vec3 v, out vec4 bounds)
{
    vec3 a = cross(t, v), b = cross(v, s), c = cross(s, t); // columns of K, times its determinant
    vec3 kx = vec3(a.x, b.x, c.x), ky = vec3(a.y, b.y, c.y), k1 = vec3(a.z, b.z, c.z);
    float aa = k1.z * k1.z - dot(k1.xy, k1.xy);
    vec2 ab = vec2(kx.z * k1.z - dot(kx.xy, k1.xy), ky.z * k1.z - dot(ky.xy, k1.xy));
    vec2 bb = vec2(kx.z * kx.z - dot(kx.xy, kx.xy), ky.z * ky.z - dot(ky.xy, ky.xy));
    vec2 root = sqrt(max(ab * ab - aa * bb, vec2(0)));
    bounds = vec4(ab - root, ab + root) / aa;
    return aa > 0;
}

// The pixel that it is counted from, and its outline's rows from there.
vec2 corner_of(GaussianWords w, uint corner)
{
    vec2 turn = vec2(corner == 0 ? 1.0 : -0.5, corner == 0 ? 0 : corner == 1 ? 0.8660254 : -0.8660254);
    vec2 middle = gaussian_place(w) + 0.5, tile = vec2(frame.tile_x, frame.tile_y);
    vec2 size = vec2(frame.tile_width, frame.tile_height);
    vec3 v = gaussian_projective(w) ? w.v.xyz : vec3(0, 0, 1);
    float det = w.s.x * w.t.y - w.s.y * w.t.x;
    mat2 inverse_ = mat2(w.t.y, -w.t.x, -w.s.y, w.s.x) / det;
    vec2 centre = -(inverse_ * vec2(w.s.z, w.t.z));
    float at = abs(dot(v.xy, centre) + v.z);
    vec2 reach = at * sqrt(vec2(dot(vec2(inverse_[0].x, inverse_[1].x), vec2(inverse_[0].x, inverse_[1].x)),
                                dot(vec2(inverse_[0].y, inverse_[1].y), vec2(inverse_[0].y, inverse_[1].y))));
    float bend = dot(abs(v.xy), reach) / at;
    float loss = LOSS * (abs(w.s.x * w.t.y) + abs(w.s.y * w.t.x)) / abs(det);
    if (bend < BEND && loss * max(reach.x, reach.y) < SLACK) {
        // A pixel is that much of s and t; twice it, so that both may be off at once.
        vec2 wider = 1 + 2 * SLACK / at * vec2(length(w.s.xy), length(w.t.xy));
        return middle + centre + inverse_ * (WIDE * at * (1 + 2 * bend) * wider * turn);
    }
    vec4 box;
    if (!conic_bounds(w.s.xyz, w.t.xyz, v, box))
        box = vec4(-1e8, -1e8, 1e8, 1e8);
    float rounding = 1 + loss * max(max(abs(box.x), abs(box.y)), max(abs(box.z), abs(box.w)));
    vec2 low = clamp(middle + box.xy - rounding, tile - 1, tile + size + 1);
    vec2 high = clamp(middle + box.zw + rounding, tile - 1, tile + size + 1);
    return low + vec2(corner == 1 ? 2 : 0, corner == 2 ? 2 : 0) * (high - low);
}

void main()
{
    uint id = frame.order.v[push_first + gl_VertexIndex / 3], corner = gl_VertexIndex % 3;
    GaussianWords w = gaussian_words(id);
    gl_Position = w.head.y > 0 ? to_clip(corner_of(w, corner), 0.5, 1) : NO_VERTEX;
    vary_head = w.head;
    vary_s = w.s;
    vary_t = w.t;
    vary_v = w.v;
    vary_clip = w.clip;
}
