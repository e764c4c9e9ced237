// A ray through layers, from the front (docs/transparency.md, "Compositing"). Needs shade.glsl.

struct Ray {
    vec3 color;    // premultiplied, of the layers so far
    float alpha;   // theirs: summed, so that layers of 1e-6 keep their own
    float through; // what they let pass: multiplied, so that it stays exact as it gets small
    vec3 tint;     // what their absorption leaves; with STP_OPTICS_ABSORBS
    uint layers;
    Look first; // the nearest layer
    Surface surface;
};

const Look LOOK_NONE = Look(vec3(0), vec3(0), 1.0 / 0.0, vec3(0));
const Surface SURFACE_NONE = Surface(0, vec3(0), 0, vec3(0), vec3(0), 0, STP_NO_ID, 0);
const Ray RAY_START = Ray(vec3(0), 0, 1, vec3(1), 0, LOOK_NONE, SURFACE_NONE);

#include "lib/deep.glsl"

// The ray begins with glass: its first layer is transparent (something opaque would have ended it),
// and meets the environment.
bool ray_glass(Ray ray)
{
    bool clear = ray.layers > 1 || (ray.layers == 1 && ray.through > 0);
    if ((OPTICS & STP_OPTICS_GLASS) == 0 || !clear)
        return false;
    return frame.optics.v[object_of_surface(true, ray.surface)].level >= 0;
}

void ray_layer(inout Ray ray, uvec2 p, Surface s, float alpha)
{
    Look look = surface_look(p, true, s);
    if (alpha == 1)
        surface_meet(look, p, true, s);
    float end = ray.through > 0 && alpha == 1 ? look.depth : ray.first.depth;
    if (ray.layers == 0) {
        ray.first = look;
        ray.surface = s;
    }
    // A host's depth takes that of what is opaque, and of nothing else.
    if (HOST_DEPTH != 0)
        ray.first.depth = end;
    ray.layers++;
    ray.color += ray.through * alpha * ray.tint * look.color;
    vec3 own = alpha * ray.tint * look.color;
    if ((OPTICS & STP_OPTICS_ABSORBS) != 0 &&
        ((OPTICS & STP_OPTICS_MULTI) != 0 || ray.layers == 1))
        ray.tint *= exp(-frame.optics.v[object_of_surface(true, s)].absorption);
    ray.alpha = alpha == 1 ? 1 : min(ray.alpha + ray.through * alpha, 1);
    ray.through *= 1 - alpha;
    if (DEEP)
        deep_layer(p, ray.layers - 1, ray_glass(ray), ray.first, ray.surface, look, own, alpha);
}

void ray_write(Ray ray, uvec2 p)
{
    vec4 color = vec4(ray.color, ray.alpha);
    if (ray_glass(ray)) {
        OpticsData o = frame.optics.v[object_of_surface(true, ray.surface)];
        vec3 d = ray_direction(pixel_position(p));
        color = vec4(surface_glass(o, ray.color, ray.through * ray.tint, ray.first.normal, d,
                                   float(ray.layers)), 1);
    }
    picture_write(p, ray.layers > 0, color, ray.first, ray.surface,
                  ray.layers);
}

// After the last layer; of a mended ray after every one, `ended` with the last.
void ray_deep(Ray ray, uvec2 p, bool ended)
{
    if (!DEEP)
        return;
    if (ended && ray_glass(ray))
        deep_behind(p, ray.layers, ray.first, ray.surface, ray.tint);
    deep_count(p, ray.layers);
}
