// A voxel's kernel: a Gaussian of one shape for the whole picture (docs/axis.md).

const float LOG2_E = 1.442695041;
const float LEAST_ALPHA = float(STP_AXIS_LEAST_ALPHA);
const float REACH2 = float(STP_AXIS_REACH * STP_AXIS_REACH);
const float LEAST_EXPONENT = -0.5 * LOG2_E * REACH2; // log2 of exp(-m^2 / 2) at the reach

// What a pixel's ray makes of the shape. With B what takes the camera frame to deviations, d the ray, q
// the kernel's centre from the ray's point at its depth (q.z = 0): m^2 = |Bq x Bd|^2 / |Bd|^2, free of the
// cancellation of far coordinates and of kernels of 10^6 : 1. Exponents are of 2, with all that depends
// on the pixel alone folded in.
struct Ray {
    vec2 d;      // the ray's direction is (d, 1); orthographic: it starts at (d, 0)
    vec2 g;      // B'B (d, 1), its x and y, over a
    float a;     // |B (d, 1)|^2
    vec3 form;   // of log2 exp(-m^2 / 2) in q: xx, 2 xy, yy
    float scale; // log2 of the line integral's factor, amplitude |(d, 1)| sqrt(2 pi / a), times LOG2_E
    float near, far; // with AXIS_CUT
};

Ray axis_ray(vec2 pixel)
{
    Ray r;
    const float b[9] = frame.axis.shape;
    vec3 x = vec3(b[0], b[3], b[6]), y = vec3(b[1], b[4], b[7]), z = vec3(b[2], b[5], b[8]);
    r.d = (pixel - vec2(frame.center[0], frame.center[1])) *
          vec2(frame.inv_focal[0], frame.inv_focal[1]);
    vec3 v = ORTHOGRAPHIC ? vec3(0, 0, 1) : vec3(r.d, 1);
    vec3 ray = v.x * x + v.y * y + v.z * z, across = cross(x, ray), down = cross(y, ray);
    r.a = dot(ray, ray);
    r.g = vec2(dot(x, ray), dot(y, ray)) / r.a;
    r.form = -0.5 * LOG2_E / r.a * vec3(dot(across, across), 2 * dot(across, down), dot(down, down));
    r.scale = log2(LOG2_E * frame.axis.scale * length(v) * inversesqrt(r.a));
    r.near = frame.near_depth;
    r.far = frame.far_depth;
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
// `log_tau` is log2 of its optical depth a scene unit; `depth` gets where its density is greatest on
// the visible part of the ray. This is what the walks' time goes into: nothing is read from memory,
// and selections are no branches (of which `&&` would be one).
float axis_alpha(Ray r, vec3 centre, float log_tau, out float depth)
{
    vec2 q = centre.xy - (ORTHOGRAPHIC ? r.d : centre.z * r.d);
    float e = q.x * (r.form.x * q.x + r.form.y * q.y) + r.form.z * q.y * q.y;
    float seen = e, share = 1;
    depth = centre.z + dot(r.g, q);
    if (AXIS_CUT) {
        float peak = depth, root = sqrt(0.5 * r.a);
        depth = clamp(peak, r.near, r.far);
        seen -= 0.5 * LOG2_E * r.a * (depth - peak) * (depth - peak);
        share = 0.5 * (erf_of(min((r.far - peak) * root, 9)) -
                       erf_of(max((r.near - peak) * root, -9)));
    }
    float x = exp2(e + (r.scale + log_tau)); // optical depth times LOG2_E
    if (AXIS_CUT)
        x *= share;
    // Thin media keep their digits: 1 - 2^-x by its series, within 1e-7 of itself.
    float thin = x * (0.693147181 - x * (0.240226507 - 0.0555041087 * x));
    float alpha = mix(1 - exp2(-x), thin, x < 0.0225);
    return mix(0, alpha, all(bvec2(seen >= LEAST_EXPONENT, alpha >= LEAST_ALPHA)));
}

vec3 axis_world_ray(vec2 pixel)
{
    const float r[9] = frame.rotation;
    vec2 d = (pixel - vec2(frame.center[0], frame.center[1])) *
             vec2(frame.inv_focal[0], frame.inv_focal[1]);
    vec3 v = ORTHOGRAPHIC ? vec3(0, 0, 1) : vec3(d, 1);
    return vec3(r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
                r[2] * v.x + r[5] * v.y + r[8] * v.z);
}

// Of a walk (axis; + 4: backwards) on the ray of world direction v: HM 5.2.
float axis_weight(uint walk, vec3 v)
{
    vec3 size = abs(v);
    float most = max(size.x, max(size.y, size.z));
    uint axis = walk & 3, dominant = size.x == most ? 0 : size.y == most ? 1 : 2;
    float own = (walk & 4) != 0 ? -v[axis] : v[axis];
    if (frame.axis.merge == STP_AXIS_MERGE_CLIP)
        return axis == dominant && own > 0 ? 1 : 0;
    if (frame.axis.merge != STP_AXIS_MERGE_BLEND)
        return 1;
    return max(own / most - frame.axis.h, 0) / (1 - frame.axis.h);
}
