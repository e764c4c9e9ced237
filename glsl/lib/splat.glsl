// A splat on the screen (docs/numerics.md). Camera frame: x right, y down, z forward.

#include "lib/sample.glsl"
#include "lib/precise.glsl"

// A point of the picture: whole pixels and a fraction, so that offsets keep their precision.
struct Place {
    ivec2 whole;
    vec2 part;
};

// In double where the device can.
#ifdef WITH_FLOAT64
#define REAL double
#define REAL2 dvec2
#define REAL3 dvec3
#define FRAME(name) frame.name##64
#else
#define REAL float
#define REAL2 vec2
#define REAL3 vec3
#define FRAME(name) frame.name
#endif
#include "lib/phong.glsl"

struct Splat {
    vec3 center, normal;
    float radius;
    uint tag;  // STP_TAG_*, object << 8
    Place place;
    Phong phong; // with PHONG
};

// With offset d from the projected centre, in pixels:
//   den = g + ab.d,  rho^2 = (q.x (dx + q.y dy)^2 + q.z dy^2) / den^2,  depth = zc + h.d / den
struct Footprint {
    Place p;
    float g;
    vec2 ab;
    vec3 q; // the form by its squares: both are positive, so that thin ellipses keep their tips
    float zc;
    vec2 h;
    float reach; // a floored splat's depth stays within zc +- reach; else infinite
    vec4 st;     // with PHONG: (s, t) den = st.xy (dx + q.y dy) + st.zw dy
};

struct Fragment {
    float rho2, depth;
    vec2 st; // with PHONG: BSK Eq. 1
};

uint splat_group(Splat s)
{
    return s.tag & STP_TAG_GROUP;
}

vec2 place_position(Place p)
{
    return vec2(p.whole) + p.part;
}

// From the place to the sample of a pixel of the whole picture.
vec2 place_offset(Place p, uvec2 pixel)
{
    PRECISE vec2 offset = vec2(ivec2(pixel) - p.whole) + (sample_part(pixel) - p.part);
    return offset;
}

// Camera frame and projection of the centre, in double where the device can: a pixel on an outline
// then falls on the side where the reference puts it (docs/results/accuracy.md). Only products and
// sums are done in double; the quotient is float, with its remainder beside it.
void splat_place(vec3 a, inout Splat s)
{
    const REAL r[9] = FRAME(rotation), t[3] = FRAME(translation);
    PRECISE REAL3 c = REAL3(r[0] * a.x + r[1] * a.y + r[2] * a.z + t[0],
                    r[3] * a.x + r[4] * a.y + r[5] * a.z + t[1],
                    r[6] * a.x + r[7] * a.y + r[8] * a.z + t[2]);
    s.center = vec3(c);
    REAL2 scale = REAL2(FRAME(focal)[0], FRAME(focal)[1]);
    REAL2 middle = REAL2(FRAME(center)[0], FRAME(center)[1]);
    PRECISE REAL2 d = c.xy;
    if (!ORTHOGRAPHIC) {
        PRECISE vec2 quotient = s.center.xy / s.center.z;
        PRECISE vec2 remainder = vec2(c.xy - REAL2(quotient) * c.z) / s.center.z;
        d = REAL2(quotient) + REAL2(remainder);
    }
    // A splat far outside the picture keeps its place within what an int holds.
    PRECISE REAL2 p = middle + scale * d;
    vec2 whole = floor(clamp(vec2(p), vec2(-1e8), vec2(1e8)));
    PRECISE REAL2 part = p - REAL2(whole);
    s.place = Place(ivec2(whole), vec2(part));
}

// False: culled, or invisible. OPAQUE_ONLY: so is what is transparent.
bool splat_load(uint id, out Splat s)
{
    vec4 a = frame.splats.v[2 * id], b = frame.splats.v[2 * id + 1];
    const float r[9] = frame.rotation;
    splat_place(a.xyz, s);
    PRECISE vec3 n =
        vec3(r[0] * b.x + r[1] * b.y + r[2] * b.z, r[3] * b.x + r[4] * b.y + r[5] * b.z,
             r[6] * b.x + r[7] * b.y + r[8] * b.z);
    s.normal = n;
    s.radius = a.w;
    s.tag = floatBitsToUint(b.w);
    bool unknown = HAS_UNKNOWN && b.x == 0 && b.y == 0 && b.z == 0;
    if (unknown)
        s.normal = ORTHOGRAPHIC ? vec3(0, 0, -1) : s.center * -inversesqrt(inner(s.center, s.center));
    // Which side is seen, from what was given: a rotated normal has been rounded once more.
    PRECISE REAL3 eye = REAL3(FRAME(eye)[0], FRAME(eye)[1], FRAME(eye)[2]);
    PRECISE REAL3 sight = ORTHOGRAPHIC ? eye : REAL3(a.xyz) - eye;
    PRECISE REAL away = b.x * sight.x + b.y * sight.y + b.z * sight.z;
    bool turned = TWO_SIDED && away > 0, faces = away < 0 || unknown;
    if (turned)
        s.normal = -s.normal;
    if (PHONG != 0)
        s.phong = phong_load(id, b.xyz, s.normal, turned ? -1 : 1);
    if (PHONG != 0 && CULL_BACK)
        faces = faces || phong_faces(id, b.xyz, -sight);
#ifdef OPAQUE_ONLY
    bool invisible = (s.tag & STP_TAG_OPAQUE) == 0;
#else
    bool invisible = OPACITY != 0 && (s.tag & STP_TAG_INVISIBLE) != 0;
#endif
    return !invisible && (!CULL_BACK || faces);
}

vec2 splat_direction(Splat s)
{
    PRECISE vec2 d = ORTHOGRAPHIC ? s.center.xy : s.center.xy / s.center.z;
    return d;
}

// A symmetric form a dx^2 + 2 b dx dy + c dy^2, and root = sqrt(a c - b^2), which every caller has
// as a product: the difference would cancel.
struct Form {
    float a, b, c, root;
};

// Completed squares. An a of 0 is a disc seen edge-on along a row: NaN, so that no pixel is hit.
vec3 form_squares(float a, float b, float root)
{
    PRECISE vec3 q = vec3(a, b / a, root * (root / a));
    return q;
}

// Largest eigenvalue, and its unit eigenvector.
float form_major(Form q, out vec2 axis)
{
    PRECISE float mean = 0.5 * (q.a + q.c), half_ = 0.5 * (q.a - q.c);
    PRECISE float spread = sqrt(half_ * half_ + q.b * q.b);
    PRECISE vec2 along = half_ >= 0 ? vec2(half_ + spread, q.b) : vec2(q.b, spread - half_);
    PRECISE float l = inner(along, along), major = mean + spread;
    axis = l > 0 ? along * inversesqrt(l) : vec2(1, 0);
    return major;
}

// Of an ellipse (docs/phong.md); first and second: the columns of the map to (s, t) den.
Form form_ellipse(Splat s, out vec2 first, out vec2 second)
{
    float scale = ORTHOGRAPHIC ? 1 : s.center.z;
    vec2 d = ORTHOGRAPHIC ? vec2(0) : splat_direction(s);
    phong_columns(s.phong, d, scale, first, second);
    PRECISE float g = inner(s.normal.xy, d) + s.normal.z;
    PRECISE float area = scale / s.phong.radius.x * (scale / s.phong.radius.y);
    PRECISE float root = area * frame.inv_focal[0] * frame.inv_focal[1] * g;
    PRECISE Form q = Form(inner(first, first), inner(first, second), inner(second, second), root);
    return q;
}

// rho^2 den^2. Diagonals are sums of squares for the same reason.
Form form_exact(Splat s)
{
    vec2 i = vec2(frame.inv_focal[0], frame.inv_focal[1]), n = s.normal.xy * i;
    PRECISE Form q;
    if (ORTHOGRAPHIC) {
        float k = 1 / (s.radius * s.radius);
        vec2 m = s.normal.z * i, square = k * (m * m + n * n);
        q = Form(square.x, k * n.x * n.y, square.y, k * i.x * i.y * s.normal.z);
    } else {
        vec2 d = splat_direction(s);
        float alpha = s.center.z / s.radius, g = inner(s.normal.xy, d) + s.normal.z;
        alpha *= alpha;
        vec2 m = g * i - d * n, square = alpha * (m * m + n * n * (1 + d.yx * d.yx));
        float cross_ = n.x * n.y * (inner(d, d) + 1) - g * (n.x * d.y * i.y + n.y * d.x * i.x);
        q = Form(square.x, alpha * cross_, square.y, alpha * i.x * i.y * g);
    }
    return q;
}

// All but the form.
Footprint footprint_plane(Splat s)
{
    PRECISE Footprint f;
    vec2 n = s.normal.xy * vec2(frame.inv_focal[0], frame.inv_focal[1]);
    f.p = s.place;
    f.zc = s.center.z;
    f.reach = 1.0 / 0.0;
    f.g = ORTHOGRAPHIC ? s.normal.z : inner(s.normal.xy, splat_direction(s)) + s.normal.z;
    f.ab = ORTHOGRAPHIC ? vec2(0) : n;
    f.h = ORTHOGRAPHIC ? -n : -s.center.z * n;
    return f;
}

// The screen-space floor: true when the splat is drawn by its floored affine ellipse.
bool footprint_floor(Splat s, Form q, vec2 first, vec2 second, inout Footprint f)
{
    vec2 axis, radius = PHONG != 0 ? s.phong.radius : vec2(s.radius);
    float major = form_major(q, axis), least = 4 / (frame.floor_size * frame.floor_size);
    PRECISE float g2 = f.g * f.g;
    PRECISE vec2 scale = (ORTHOGRAPHIC ? 1 : s.center.z) / radius;
    PRECISE float area = scale.x * scale.y * frame.inv_focal[0] * frame.inv_focal[1]; // root / g
    PRECISE float minor = min(area * (area / major), least), lift = least - minor;
    if (!(major > least * g2) || s.center.z < frame.near_depth)
        return false;
    vec2 d = splat_direction(s);
    PRECISE float view2 = ORTHOGRAPHIC ? 1 : inner(d, d) + 1;
    bool across = g2 > 1e-14 * view2; // not edge-on
    f.h = across ? f.h / f.g : vec2(0);
    if (PHONG != 0)
        f.st = phong_floored(first, second, axis, sqrt(least), sqrt(minor), across && f.g > 0 ? 1 : -1,
                             s.phong.side * (across && f.g > 0 ? 1 : -1));
    f.reach = s.radius;
    PRECISE vec2 row = lift * axis.x * axis + vec2(minor, 0);
    f.q = form_squares(row.x, row.y, sqrt(minor * least));
    f.g = 1;
    f.ab = vec2(0);
    return true;
}

Footprint footprint_make(Splat s, out bool floored)
{
    Footprint f = footprint_plane(s);
    vec2 first, second;
    Form q;
    if (PHONG != 0)
        q = form_ellipse(s, first, second);
    else
        q = form_exact(s);
    floored = FLOOR ? footprint_floor(s, q, first, second, f) : false;
    if (!floored) {
        f.q = form_squares(q.a, q.b, q.root);
        PRECISE vec2 across = vec2(-first.y, first.x) * (s.phong.side * (q.root / q.a));
        f.st = vec4(first, across);
    }
    return f;
}

bool fragment_seen(Phong e, Fragment fragment)
{
    bool seen = !CUTS || (fragment.depth >= frame.near_depth && fragment.depth <= frame.far_depth);
    return PHONG == 2 ? seen && clip_keeps(e, fragment.st) : seen;
}

// False: the pixel's ray misses. d: sample minus the projected centre.
bool footprint_hit(Footprint f, Phong e, vec2 d, out Fragment fragment)
{
    PRECISE float den = f.g + f.ab.x * d.x + f.ab.y * d.y;
    PRECISE float u = d.x + f.q.y * d.y, form = f.q.x * u * u + f.q.z * d.y * d.y;
    PRECISE float inv = 1 / den;
    PRECISE float rise = (f.h.x * d.x + f.h.y * d.y) * inv;
    PRECISE float depth = f.zc + (FLOOR ? clamp(rise, -f.reach, f.reach) : rise);
    PRECISE float rho2 = form * inv * inv;
    PRECISE vec2 st = PHONG != 0 ? (f.st.xy * u + f.st.zw * d.y) * inv : vec2(0);
    fragment = Fragment(rho2, depth, st);
    // A den of 0 is an edge-on plane through the eye: no depth.
    return form <= den * den && den != 0 && fragment_seen(e, fragment);
}

// A depth as bits that order as it does: depths of orthographic views may be negative, so they are
// taken above the scene's nearest. The minimum changes no depth. It makes the value an integer's:
// Mesa 22.3's lavapipe does a 32-bit atomic in the type of the instruction that made its value, and
// a minimum of floats never replaces a word whose bits are a NaN's.
uint depth_order(float depth)
{
    return min(floatBitsToUint(ORTHOGRAPHIC ? max(depth - frame.depth_low, 0) : depth), 0x7f800000u);
}

float depth_ordered(uint order)
{
    return uintBitsToFloat(order) + (ORTHOGRAPHIC ? frame.depth_low : 0);
}

// The same of a disc that crosses the near plane, where the projected centre is no place to start
// from: it may be anywhere. The ray meets the plane at depth n.c / n.ray.
bool clipped_hit(Splat s, uvec2 pixel, out Fragment fragment)
{
    vec2 c = vec2(frame.center[0], frame.center[1]);
    vec2 inv = vec2(frame.inv_focal[0], frame.inv_focal[1]);
    PRECISE vec3 ray = vec3((vec2(pixel) + sample_part(pixel) - c) * inv, 1);
    PRECISE float depth = inner(s.normal, s.center) / inner(s.normal, ray);
    PRECISE vec3 v = depth * ray - s.center;
    if (PHONG != 0) {
        PRECISE vec2 st = vec2(inner(v, s.phong.u), inner(v, s.phong.v)) / s.phong.radius;
        PRECISE float rho2 = inner(st, st);
        fragment = Fragment(rho2, depth, st);
    } else {
        PRECISE vec3 w = v / s.radius;
        PRECISE float rho2 = inner(w, w);
        fragment = Fragment(rho2, depth, vec2(0));
    }
    return fragment.rho2 <= 1 && fragment_seen(s.phong, fragment);
}

// Turned to the eye as the splat is.
vec3 fragment_normal(Splat s, Fragment f)
{
    if (PHONG == 0)
        return s.normal;
    return phong_normal(s.phong, s.normal, f.st);
}

PRECISE float kernel_weight(float rho2)
{
    return GAUSS ? exp(-2 * rho2) : max(0, 1 - rho2);
}

#include "lib/bounds.glsl"

// One of the opaque ones of a scene that is transparent elsewhere.
bool splat_opaque(uint id)
{
    return MIXED &&
           (floatBitsToUint(frame.splats.v[2 * splat_known(id) + 1].w) & STP_TAG_OPAQUE) != 0;
}

// In a scene that is transparent somewhere.
float splat_opacity(uint id)
{
    return OPACITY == 2 ? frame.opacities.v[splat_known(id)] : frame.opacity;
}

// The epsilon of the object that splat `id` belongs to.
float object_epsilon(uint id)
{
    if (!HAS_OBJECTS)
        return frame.epsilon;
    return frame.materials.v[floatBitsToUint(frame.splats.v[2 * splat_known(id) + 1].w) >> 8].epsilon;
}
