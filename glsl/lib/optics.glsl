// What a surface mirrors and lets through of the environment (docs/glass.md).
#include "lib/environment.glsl"

// The share that an interface reflects, channel by channel: exact for a dielectric of relative
// index `ior` (inside over outside), unpolarised; Schlick's for a mirror. c: cosine of incidence.
// passed: the share of what is behind; a mirror's colour leaves no other behind.
vec3 interface_fresnel(OpticsData o, vec3 ior, float c, out vec3 passed)
{
    vec3 sine2 = (1 - c * c) / (ior * ior), ct = sqrt(max(vec3(0), 1 - sine2));
    vec3 s = (c - ior * ct) / (c + ior * ct), p = (ior * c - ct) / (ior * c + ct);
    vec3 f = mix(0.5 * (s * s + p * p), vec3(1), greaterThanEqual(sine2, vec3(1)));
    passed = 1 - f;
    if ((OPTICS & STP_OPTICS_MIRRORS) != 0 && any(greaterThan(o.reflectance, vec3(0)))) {
        float m = 1 - c, m2 = m * m;
        f = o.reflectance + (1 - o.reflectance) * (m2 * m2 * m);
        passed = vec3(1 - max(f.r, max(f.g, f.b)));
    }
    return f;
}

// An opaque surface under its interface, the same from both sides. color: what it sends to the eye
// by itself; n: unit, either way; d: unit, along the eye's ray.
vec3 surface_mirrors(OpticsData o, vec3 color, vec3 n, vec3 d)
{
    float c = dot(d, n);
    vec3 passed, f = interface_fresnel(o, o.ior, min(abs(c), 1), passed);
    return passed * color + f * environment_at(normalize(d - 2 * c * n), o.level);
}

// ZP Eq. 12 with sin theta_T = scale * |along|: along is what d has along the surface.
vec3 glass_bend(vec3 along, vec3 facing, float scale)
{
    vec3 t = scale * along;
    return normalize(t - sqrt(max(0, 1 - dot(t, t))) * facing);
}

// A transparent surface that meets the environment.
struct Glass {
    vec3 passed, mirrored; // share of what comes through; light that it mirrors
    vec3 seen;             // of the environment, through `layers` of them
};

Glass glass_at(OpticsData o, vec3 n, vec3 d, float layers)
{
    Glass g;
    float dn = dot(d, n), c = min(abs(dn), 1);
    vec3 facing = dn > 0 ? -n : n, along = d + c * facing;
    vec3 ior = dn > 0 ? 1 / o.ior : o.ior;
    float power = (OPTICS & STP_OPTICS_MULTI) != 0 ? layers : 1;
    // Beyond total reflection the ray leaves along the surface.
    vec3 scale = min(exp2(-power * log2(ior)), vec3(1 / max(length(along), 1e-6)));
    g.seen = environment_at(glass_bend(along, facing, scale.r), o.level);
    if ((OPTICS & STP_OPTICS_DISPERSE) != 0) {
        g.seen.g = environment_at(glass_bend(along, facing, scale.g), o.level).g;
        g.seen.b = environment_at(glass_bend(along, facing, scale.b), o.level).b;
    }
    vec3 mirror = environment_at(normalize(d - 2 * dn * n), o.level);
    vec3 f = interface_fresnel(o, ior, c, g.passed);
    g.mirrored = f * mirror;
    return g;
}

// The nearest, transparent layer of a ray through `layers` of them. own: the layers' light,
// premultiplied; through: what they all let pass.
vec3 surface_glass(OpticsData o, vec3 own, vec3 through, vec3 n, vec3 d, float layers)
{
    Glass g = glass_at(o, n, d, layers);
    return g.passed * (own + through * g.seen) + g.mirrored;
}
