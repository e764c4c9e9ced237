// A voxel's kernel: a Gaussian of one shape for the whole picture (docs/axis.md).

// What a pixel's ray makes of the shape. With d the ray, q the kernel's centre from the ray's point at
// its depth (q.z = 0): m^2 = q' M q - (g.q)^2 / A, free of the cancellation of far coordinates.
struct Ray {
    vec2 d;      // the ray's direction is (d, 1); orthographic: it starts at (d, 0)
    vec2 g;      // M (d, 1), its x and y, over a
    float a;     // (d, 1)' M (d, 1)
    vec3 form;   // of m^2 in q: xx, 2 xy, yy
    float scale; // of the line integral: amplitude |(d, 1)| sqrt(2 pi / a)
};

Ray axis_ray(vec2 pixel)
{
    Ray r;
    const float m[6] = frame.axis.shape;
    r.d = (pixel - vec2(frame.center[0], frame.center[1])) *
          vec2(frame.inv_focal[0], frame.inv_focal[1]);
    vec3 v = ORTHOGRAPHIC ? vec3(0, 0, 1) : vec3(r.d, 1);
    vec3 mv = vec3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[1] * v.x + m[3] * v.y + m[4] * v.z,
                   m[2] * v.x + m[4] * v.y + m[5] * v.z);
    r.a = dot(v, mv);
    r.g = mv.xy / r.a;
    r.form = vec3(m[0] - mv.x * r.g.x, 2 * (m[1] - mv.x * r.g.y), m[3] - mv.y * r.g.y);
    r.scale = frame.axis.scale * length(v) * inversesqrt(r.a);
    return r;
}

// Abramowitz and Stegun 7.1.26: within 1.5e-7.
float erf_of(float x)
{
    float t = 1 / (1 + 0.3275911 * abs(x));
    float p = t * (0.254829592 +
                   t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    float e = 1 - p * exp(-x * x);
    return x < 0 ? -e : e;
}

// The opacity that a kernel at `centre` (camera frame) adds to the ray, 0 where it has no fragment;
// `depth` gets where its density is greatest on the visible part of the ray.
float axis_alpha(Ray r, vec3 centre, float tau, out float depth)
{
    vec2 q = centre.xy - (ORTHOGRAPHIC ? r.d : centre.z * r.d);
    float m2 = r.form.x * q.x * q.x + r.form.y * q.x * q.y + r.form.z * q.y * q.y;
    float seen = m2, share = 1;
    depth = centre.z + dot(r.g, q);
    if (AXIS_CUT) {
        float peak = depth, root = sqrt(0.5 * r.a);
        depth = clamp(peak, frame.near_depth, frame.far_depth);
        seen += r.a * (depth - peak) * (depth - peak);
        share = 0.5 * (erf_of(min((frame.far_depth - peak) * root, 9)) -
                       erf_of(max((frame.near_depth - peak) * root, -9)));
    }
    float x = tau * r.scale * share * exp(-0.5 * max(m2, 0));
    float alpha = x < 0.015625 ? x * (1 - x * (0.5 - x / 6)) : 1 - exp(-x); // thin media keep digits
    return seen <= frame.axis.reach2 && alpha >= frame.axis.least_alpha ? alpha : 0;
}
