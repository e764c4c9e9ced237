// Deferred shading, one for every method: averaged attributes in, the picture's channels out.
#include "lib/light.glsl"
#include "lib/optics.glsl"

// Which of the materials is the surface's.
#ifndef SURFACE_OBJECT
#define SURFACE_OBJECT(s) (floatBitsToUint(frame.splats.v[2 * splat_known(s.id) + 1].w) >> 8)
#endif

struct Surface {
    float weight;     // sum of weights
    vec3 normal;      // weighted sum, camera frame
    float depth;      // averaged
    vec3 albedo;      // weighted sum; unused without HAS_COLOR
    vec3 near_normal; // of the nearest fragment: stands in where sums vanish
    float near_depth;
    uint id;          // nearest splat, or STP_NO_ID where the payload has none
    uint fragments;
};

vec3 world_normal(vec3 n)
{
    const float r[9] = frame.rotation;
    return vec3(r[0] * n.x + r[3] * n.y + r[6] * n.z, r[1] * n.x + r[4] * n.y + r[7] * n.z,
                r[2] * n.x + r[5] * n.y + r[8] * n.z);
}

// What a surface looks like, and the rest of what it leaves in the picture.
struct Look {
    vec3 color; // shaded, as if opaque
    vec3 normal;
    float depth;
    vec3 albedo;
};

uint object_of_surface(bool hit, Surface s)
{
    if (!HAS_OBJECTS)
        return 0;
    return hit ? SURFACE_OBJECT(s) : 0;
}

// Then the nearest fragment's normal and albedo stand in. Precise: two modules may share a picture's
// pixels by it (twopass_resolve.comp).
bool surface_vanished(Surface s)
{
    precise float length2 = s.normal.x * s.normal.x + s.normal.y * s.normal.y + s.normal.z * s.normal.z;
    return !(s.weight >= 1e-6 && length2 >= 1e-12);
}

Look surface_look(uvec2 p, bool hit, Surface s)
{
    Look look;
    bool vanished = surface_vanished(s);
    look.normal = vanished ? s.near_normal : s.normal * inversesqrt(dot(s.normal, s.normal));
    look.depth = s.weight >= 1e-6 ? s.depth : s.near_depth;
    MaterialData m = material_at(object_of_surface(hit, s));
    look.albedo = m.albedo;
    if (HAS_COLOR)
        look.albedo = vanished || SHADE != 0 ? frame.colors.v[hit ? splat_known(s.id) : 0] : s.albedo / s.weight;
    look.color = shade(m, look.albedo, look.normal, pixel_position(p), look.depth);
    if (SHADE == 1 && s.weight >= 1e-6)
        look.color = s.albedo / s.weight; // shaded already
    return look;
}

// An opaque surface that meets the environment.
void surface_meet(inout Look look, uvec2 p, bool hit, Surface s)
{
    if ((OPTICS & STP_OPTICS_SURFACE) != 0)
        look.color = surface_mirrors(frame.optics.v[object_of_surface(hit, s)], look.color, look.normal,
                                     ray_direction(pixel_position(p)));
}

// One more sample that hit. Where all is opaque alpha holds the hits exactly: a wholly covered pixel
// ends at 1.
vec4 sample_add(vec4 mean, vec4 color, uint at, out uint hits)
{
    if (OPACITY != 0) {
        uint before = (AOVS & 2) != 0 ? frame.out_id.v[ID_WORDS * at + 3] : 0;
        hits = before == STP_NO_ID ? 1 : before + 1;
        return mean + color / float(SAMPLES);
    }
    hits = uint(mean.w * float(SAMPLES) + 0.5) + 1;
    float alpha = hits == SAMPLES ? 1 : float(hits) / float(SAMPLES);
    return vec4(mean.xyz + color.xyz / float(SAMPLES), alpha);
}

// As two words: a CPU device stores component by component, and lane by lane.
void color_write(uint at, vec4 color)
{
    uvec4 bits = floatBitsToUint(color);
    U64Vec2Ref(uint64_t(frame.out_color)).v[at] = u64vec2(packUint2x32(bits.xy), packUint2x32(bits.zw));
}

// Writes the pixel at p (relative to the tile). color: premultiplied; the rest is that of the
// nearest of its layers. hit false: nothing is there. With several samples the picture starts
// cleared; colours add up, and the rest is that of the nearest sample.
void picture_write(uvec2 p, bool hit, vec4 color, Look look, Surface s, uint layers)
{
    if (SAMPLE_GRID > 1 && !hit)
        return;
    uint at = p.y * frame.tile_width + p.x, hits = 1;
    if (!hit)
        color = vec4(0);
    if (BACKGROUND && OPACITY == 0 && !hit)
        color = background_at(pixel_position(p));
    if (SAMPLE_GRID > 1)
        color = sample_add(frame.out_color.v[at], color, at, hits);
    color_write(at, color);
    if (SAMPLE_GRID > 1 && (AOVS & 2) != 0)
        frame.out_id.v[ID_WORDS * at + 3] = hits;
    if (SAMPLE_GRID > 1 && look.depth >= frame.out_depth.v[at])
        return;
    frame.out_normal.v[at] = hit ? world_normal(look.normal) : vec3(0);
    frame.out_depth.v[at] = hit ? look.depth : 1.0 / 0.0;
    if ((AOVS & 1) != 0)
        frame.out_albedo.v[at] = hit ? vec4(look.albedo, s.weight) : vec4(0);
    if ((AOVS & 2) != 0) {
        frame.out_id.v[ID_WORDS * at] = hit ? s.id : STP_NO_ID;
        frame.out_id.v[ID_WORDS * at + 1] = hit ? s.fragments : 0;
        if (SAMPLE_GRID > 1)
            frame.out_id.v[ID_WORDS * at + 2] = push_sample;
        if ((AOVS & 4) != 0)
            frame.out_id.v[ID_WORDS * at + ID_WORDS - 1] = hit ? layers : 0;
    }
}

// An opaque pixel.
void surface_write(uvec2 p, bool hit, Surface s)
{
    Look look = surface_look(p, hit, s);
    surface_meet(look, p, hit, s);
    picture_write(p, hit, vec4(look.color, 1), look, s, 1);
}
