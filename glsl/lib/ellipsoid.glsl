// Ellipsoids of range images, each with a shape of its own (docs/range.md). Needs lib/axis.glsl.
#include "lib/projected.glsl"

const float SQRT_2_PI = 2.50662827;

// Its precision is R'R, R = (r.x r.y r.z; 0 s.x s.y; 0 0 s.z): a factor keeps the digits that the
// precision of a long ellipsoid would lose.
struct Ellipsoid {
    vec3 centre;
    float tau;
    vec3 r, s;
    vec3 extent; // of the box around its reach
};

// From its axes in the camera frame. The factor's inverse is triangular too, U with the covariance
// U U'; all its entries come from cross products of the rows of the matrix of axes, which do not cancel.
void ellipsoid_factor(vec3 a, vec3 b, vec3 c, inout Ellipsoid e)
{
    vec3 x = vec3(a.x, b.x, c.x), y = vec3(a.y, b.y, c.y), z = vec3(a.z, b.z, c.z);
    vec3 yz = cross(y, z), xz = cross(x, z);
    float u33 = length(z), area = length(yz), u22 = area / u33;
    float u11 = abs(dot(a, cross(b, c))) / area;
    float u23 = dot(y, z) / u33, u13 = dot(x, z) / u33, u12 = dot(xz, yz) / (u33 * area);
    e.r = vec3(1 / u11, -u12 / (u11 * u22), (u12 * u23 - u22 * u13) / (u11 * u22 * u33));
    e.s = vec3(1 / u22, -u23 / (u22 * u33), 1 / u33);
    e.extent = float(STP_AXIS_REACH) * vec3(length(x), length(y), u33);
}

void ellipsoid_store(uint at, Ellipsoid e, vec3 color)
{
    at *= STP_ELLIPSOID_DRAWN;
    frame.projected.v[at] = vec4(e.centre, e.tau);
    frame.projected.v[at + 1] = vec4(color, e.extent.x);
    frame.projected.v[at + 2] = vec4(e.r, e.extent.y);
    frame.projected.v[at + 3] = vec4(e.s, e.extent.z);
}

Ellipsoid ellipsoid_load(uint at, out vec3 color)
{
    at *= STP_ELLIPSOID_DRAWN;
    vec4 a = projected_at(at), b = projected_at(at + 1);
    vec4 c = projected_at(at + 2), d = projected_at(at + 3);
    color = b.xyz;
    return Ellipsoid(a.xyz, a.w, c.xyz, d.xyz, vec3(b.w, c.w, d.w));
}

// The ray (d, 1), or (0, 0, 1) from (d, 0), where the ellipsoid is the unit ball.
vec3 ellipsoid_ray(Ellipsoid e, vec2 d)
{
    vec3 v = ORTHOGRAPHIC ? vec3(0, 0, 1) : vec3(d, 1);
    return vec3(dot(e.r, v), dot(e.s.xy, v.yz), e.s.z);
}

// As axis_alpha. With q from the ray's point at the centre's depth to the centre (q.z = 0), whitened to
// w: m^2 = |w x u|^2 / |u|^2, a sum of squares.
float ellipsoid_alpha(Ellipsoid e, vec2 d, out float depth)
{
    vec3 u = ellipsoid_ray(e, d);
    vec2 q = e.centre.xy - (ORTHOGRAPHIC ? d : e.centre.z * d);
    vec2 w = vec2(dot(e.r.xy, q), e.s.x * q.y);
    float a = dot(u, u), inv = 1 / a, across = w.x * u.y - w.y * u.x;
    float m2 = (across * across + u.z * u.z * dot(w, w)) * inv, seen = m2, share = 1;
    depth = e.centre.z + dot(w, u.xy) * inv;
    if (AXIS_CUT) {
        float peak = depth, root = sqrt(0.5 * a);
        depth = clamp(peak, frame.near_depth, frame.far_depth);
        seen += a * (depth - peak) * (depth - peak);
        share = 0.5 * (erf_of(min((frame.far_depth - peak) * root, 9)) -
                       erf_of(max((frame.near_depth - peak) * root, -9)));
    }
    float along = sqrt(ORTHOGRAPHIC ? inv : (dot(d, d) + 1) * inv);
    float x = e.tau * SQRT_2_PI * along * share * exp(-0.5 * m2);
    float alpha = mix(1 - exp(-x), x * (1 - x * (0.5 - x * (1.0 / 6))), x < 0.015625);
    return mix(0, alpha, all(bvec2(seen <= REACH2, alpha >= LEAST_ALPHA)));
}

// The form of m^2 in q at the centre's ray: xx, xy, yy.
vec3 ellipsoid_form(Ellipsoid e)
{
    vec3 u = ellipsoid_ray(e, ORTHOGRAPHIC ? vec2(0) : e.centre.xy / e.centre.z);
    float a = dot(u, u), zz = u.z * u.z, c = e.r.y * u.y - e.s.x * u.x;
    return vec3(e.r.x * e.r.x * (u.y * u.y + zz), e.r.x * (u.y * c + zz * e.r.y),
                c * c + zz * (e.r.y * e.r.y + e.s.x * e.s.x)) /
           a;
}
