// A ray through layers, from the front (docs/transparency.md, "Compositing"). Needs shade.glsl.

struct Ray {
    vec3 color;    // premultiplied, of the layers so far
    float alpha;   // theirs: summed, so that layers of 1e-6 keep their own
    float through; // what they let pass: multiplied, so that it stays exact as it gets small
    uint layers;
    Look first; // the nearest layer
    Surface surface;
};

const Look LOOK_NONE = Look(vec3(0), vec3(0), 1.0 / 0.0, vec3(0));
const Surface SURFACE_NONE = Surface(0, vec3(0), 0, vec3(0), vec3(0), 0, STP_NO_ID, 0);
const Ray RAY_START = Ray(vec3(0), 0, 1, 0, LOOK_NONE, SURFACE_NONE);

void ray_layer(inout Ray ray, uvec2 p, Surface s, float alpha)
{
    Look look = surface_look(p, true, s);
    if (ray.layers == 0) {
        ray.first = look;
        ray.surface = s;
    }
    ray.layers++;
    ray.color += ray.through * alpha * look.color;
    ray.alpha = alpha == 1 ? 1 : min(ray.alpha + ray.through * alpha, 1);
    ray.through *= 1 - alpha;
}

void ray_write(Ray ray, uvec2 p)
{
    picture_write(p, ray.layers > 0, vec4(ray.color, ray.alpha), ray.first, ray.surface,
                  ray.layers);
}
