// Layers kept one by one, for deep pictures (docs/exr.md). A pixel keeps STP_DEEP_WINDOW of them at
// once, in a ring: those from frame.deep_first on, or, where its ray is mended, those of the last
// turns. Flattened they are the pixel, glass too. Needs layers.glsl, which includes this.

// MENDED_RAYS: this pass takes a layer a turn.
#ifdef MENDED_RAYS
const bool RAY_MENDED = true;
#else
const bool RAY_MENDED = false;
#endif

bool deep_kept(uint layer)
{
    return RAY_MENDED || layer - frame.deep_first < STP_DEEP_WINDOW;
}

// Layers of one rank lie together in a block, as slots do.
uint deep_at(uint pixel, uint layer)
{
    const uint block = STP_BLOCK * STP_BLOCK;
    uint rank = pixel / block * STP_DEEP_WINDOW + layer % STP_DEEP_WINDOW;
    return (rank * block + pixel % block) * STP_DEEP_FLOATS;
}

void deep_store(uint at, float depth, vec3 color, float alpha)
{
    frame.deep_layers.v[at] = depth;
    frame.deep_layers.v[at + 1] = color.r;
    frame.deep_layers.v[at + 2] = color.g;
    frame.deep_layers.v[at + 3] = color.b;
    frame.deep_layers.v[at + 4] = alpha;
}

// Layer number `layer` (from 0) of a ray; the glass that the ray begins with lets through its share,
// and mirrors at the nearest.
void deep_layer(uvec2 p, uint layer, bool glass, Look first, Surface surface, Look look, vec3 color,
                float alpha)
{
    uint pixel = pixel_index(p);
    if (!deep_kept(layer))
        return;
    if (glass) {
        OpticsData o = frame.optics.v[object_of_surface(true, surface)];
        Glass g = glass_at(o, first.normal, ray_direction(pixel_position(p)), 1);
        color = g.passed * color + (layer == 0 ? g.mirrored : vec3(0));
    }
    deep_store(deep_at(pixel, layer), look.depth, color, alpha);
}

// Behind the last of `layers`: what of the environment the glass lets pass. It belongs to that layer,
// which hides all else as the pixel does.
void deep_behind(uvec2 p, uint layers, Look first, Surface surface, vec3 tint)
{
    if (!deep_kept(layers - 1))
        return;
    uint at = deep_at(pixel_index(p), layers - 1);
    OpticsData o = frame.optics.v[object_of_surface(true, surface)];
    Glass g = glass_at(o, first.normal, ray_direction(pixel_position(p)), layers);
    vec3 behind = (1 - frame.deep_layers.v[at + 4]) * g.passed * tint * g.seen;
    frame.deep_layers.v[at + 1] += behind.r;
    frame.deep_layers.v[at + 2] += behind.g;
    frame.deep_layers.v[at + 3] += behind.b;
    frame.deep_layers.v[at + 4] = 1;
}

void deep_count(uvec2 p, uint layers)
{
    frame.deep_counts.v[pixel_index(p)] = layers | (RAY_MENDED ? STP_DEEP_MENDED : 0);
}
