// A surface's splat on the screen: the truncated Gaussian exp(-2 rho^2) on its disc or ellipse
// (docs/axis.md, "A surface's splat"). All is linear in the pixel, counted from one near its centre, so
// that offsets are whole numbers. Needs common.glsl.
#include "lib/projected.glsl"

const bool PROJECTIVE = !ORTHOGRAPHIC; // where no floor says otherwise

struct Gaussian {
    ivec2 at;     // that pixel, of the whole picture
    vec3 s, t, v; // of (dx, dy, 1): BSK Eq. 1 times v, and the normal along the ray; else (s, t), depth
    vec2 depth;   // normal along the centre, -1: depth is its quotient by v; else v is kept in [x, y]
    float opacity;
    vec3 color;
    vec3 clip[2]; // PHONG 2
    bool reflex;
};

uint gaussian_stride()
{
    return PHONG == 2 ? STP_GAUSSIAN_CLIPPED : STP_GAUSSIAN;
}

void gaussian_store(uint id, Gaussian g)
{
    uint at = gaussian_stride() * id;
    frame.projected.v[at] = vec4(uintBitsToFloat(uint(g.at.x) | uint(g.at.y) << 16), g.opacity, g.depth);
    frame.projected.v[at + 1] = vec4(g.s, g.color.x);
    frame.projected.v[at + 2] = vec4(g.t, g.color.y);
    frame.projected.v[at + 3] = vec4(g.v, g.color.z);
    if (PHONG == 2) {
        frame.projected.v[at + 4] = vec4(g.clip[0], g.reflex ? 1 : 0);
        frame.projected.v[at + 5] = vec4(g.clip[1], 0);
    }
}

// What is kept of it, as it lies in memory: shaders pass it on.
struct GaussianWords {
    vec4 head, s, t, v, clip[2];
};

GaussianWords gaussian_words(uint id)
{
    uint at = gaussian_stride() * id;
    GaussianWords w;
    w.head = projected_at(at);
    w.s = projected_at(at + 1);
    w.t = projected_at(at + 2);
    w.v = projected_at(at + 3);
    if (PHONG == 2) {
        w.clip[0] = projected_at(at + 4);
        w.clip[1] = projected_at(at + 5);
    }
    return w;
}

vec2 gaussian_place(GaussianWords w)
{
    uint at = floatBitsToUint(w.head.x);
    return vec2(at & 0xffffu, at >> 16);
}

vec3 gaussian_color(GaussianWords w)
{
    return vec3(w.s.w, w.t.w, w.v.w);
}

bool gaussian_projective(GaussianWords w)
{
    return PROJECTIVE && (!FLOOR || w.head.w < 0);
}

// The opacity that it adds to the ray of a pixel of the whole picture, 0 where it has no fragment.
float gaussian_alpha(GaussianWords w, vec2 pixel, out float depth)
{
    vec2 d = pixel - gaussian_place(w);
    float v = dot(w.v.xy, d) + w.v.z;
    vec2 st = vec2(dot(w.s.xy, d) + w.s.z, dot(w.t.xy, d) + w.t.z);
    bool projective = gaussian_projective(w);
    float inv = projective ? 1 / v : 1;
    st *= inv;
    depth = projective ? w.head.z * inv : clamp(v, w.head.z, w.head.w);
    float rho2 = dot(st, st), alpha = w.head.y * exp2(-2.885390082 * rho2);
    bool seen = all(bvec2(rho2 <= 1, alpha >= float(STP_AXIS_LEAST_ALPHA)));
    if (AXIS_CUT)
        seen = all(bvec3(seen, depth >= frame.near_depth, depth <= frame.far_depth));
    if (PHONG == 2) {
        float first = dot(w.clip[0].xyz, vec3(st, 1)), second = dot(w.clip[1].xyz, vec3(st, 1));
        float kept = mix(min(first, second), max(first, second), w.clip[0].w != 0);
        seen = all(bvec2(seen, kept >= 0));
    }
    return mix(0, alpha, seen);
}
