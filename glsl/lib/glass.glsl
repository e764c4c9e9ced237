// Glass where rays were not composited layer by layer (docs/transparency.md, "Glass"): how many layers
// a ray crosses is told by its opacity. Needs shade.glsl.

struct LayersLight {
    vec3 near;   // light of the nearest layer, premultiplied, where it is known apart
    vec4 rest;   // of the others, as the eye gets it, or of all
    float alpha; // opacity of the nearest layer
};

// -log(1 - alpha), of a small alpha too.
float optical_depth(float alpha)
{
    return alpha < 0.01 ? alpha * (1 + alpha * (0.5 + alpha / 3)) : -log(1 - min(alpha, 1 - 1e-6));
}

// The mean tint of `layers` layers of opacity alpha, each behind the absorption of those before it: a
// geometric series over the same without absorption.
vec3 mean_tint(vec3 absorption, float alpha, float layers)
{
    vec3 ratio = (1 - alpha) * exp(-absorption);
    vec3 sum = (1 - pow(ratio, vec3(layers))) / max(1 - ratio, vec3(1e-7));
    float plain = (1 - pow(1 - alpha, layers)) / alpha;
    return min(sum / max(plain, 1e-7), vec3(1));
}

// What the environment adds to `all`, the light and the opacity of all layers.
void glass_show(LayersLight glass, uvec2 p, Look look, Surface s, inout vec4 all)
{
    OpticsData o = frame.optics.v[object_of_surface(true, s)];
    if (o.level < 0)
        return;
    bool multi = (OPTICS & STP_OPTICS_MULTI) != 0;
    float alpha = max(glass.alpha, 1e-7), layers = max(optical_depth(all.w) / optical_depth(alpha), 1);
    vec3 own = all.xyz, tint = vec3(1);
    if ((OPTICS & STP_OPTICS_ABSORBS) != 0) {
        tint = exp(-o.absorption * (multi ? layers : 1));
        vec3 first = exp(-o.absorption);
#ifdef NEAREST
        own = glass.near + first * glass.rest.xyz *
                               (multi ? mean_tint(o.absorption, alpha, max(layers - 1, 1)) : vec3(1));
#else
        float share = min(alpha / max(all.w, 1e-7), 1); // of the nearest in the light of all
        own *= multi ? mean_tint(o.absorption, alpha, layers) : share + (1 - share) * first;
#endif
    }
    all = vec4(surface_glass(o, own, (1 - all.w) * tint, look.normal, ray_direction(pixel_position(p)),
                             layers), 1);
}
