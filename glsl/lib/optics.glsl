// What a surface mirrors of the environment (docs/glass.md, "Interface").
#include "lib/environment.glsl"

// The share that an interface reflects, channel by channel: exact for a dielectric of relative
// index `ior` (inside over outside), unpolarised; Schlick's for a mirror. c: cosine of incidence.
vec3 interface_fresnel(OpticsData o, vec3 ior, float c)
{
    vec3 sine2 = (1 - c * c) / (ior * ior), ct = sqrt(max(vec3(0), 1 - sine2));
    vec3 s = (c - ior * ct) / (c + ior * ct), p = (ior * c - ct) / (ior * c + ct);
    vec3 f = mix(0.5 * (s * s + p * p), vec3(1), greaterThanEqual(sine2, vec3(1)));
    if ((OPTICS & STP_OPTICS_MIRRORS) != 0 && any(greaterThan(o.reflectance, vec3(0)))) {
        float m = 1 - c, m2 = m * m;
        f = o.reflectance + (1 - o.reflectance) * (m2 * m2 * m);
    }
    return f;
}

// An opaque surface under its interface, the same from both sides. color: what it sends to the eye
// by itself; n: unit, either way; d: unit, along the eye's ray.
vec3 surface_mirrors(OpticsData o, vec3 color, vec3 n, vec3 d)
{
    float c = dot(d, n);
    vec3 f = interface_fresnel(o, o.ior, min(abs(c), 1));
    return mix(color, environment_at(normalize(d - 2 * c * n), o.level), f);
}
