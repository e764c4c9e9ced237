#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef LAYERS
#extension GL_ARB_shader_viewport_layer_array : require
#endif
// Three vertices a splat, pulled: the triangle around the disc, in its plane; a floored splat gets
// one around its ellipse on the screen. Fragments decide exactly, so this only has to be wide enough.
#include "lib/common.glsl"
#include "lib/clip.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/varying.glsl"
#ifdef BLENDED
#define GRAPHICS
#include "lib/pixel.glsl"
#include "lib/shade.glsl"
#include "lib/transparent.glsl"
#endif

// An equilateral triangle of inradius 1 reaches 2. Vertices are snapped to 1/256 of a pixel: where
// the disc is thinner than some of those on the screen, it gets that much more room; and so does a
// needle, for clipping rounds a vertex by 2^-24 of its length and more, which is many of its widths.
// The near plane clips so much before its place, for the edge that it leaves is snapped too.
const float WIDE = 2.1, SNAP = 0.008, NEEDLE = 1e-6, WIDEST = 6, BEFORE = 0.9;

vec4 disc_vertex(Splat s, vec2 turn)
{
    vec3 n = s.normal;
#ifdef WITH_PHONG
    vec3 along = s.phong.radius.x * s.phong.u, beside = s.phong.radius.y * s.phong.v;
    float least = min(s.phong.radius.x, s.phong.radius.y);
    float needle = NEEDLE * max(s.phong.radius.x, s.phong.radius.y) / least;
#else
    vec3 e = normalize(abs(n.x) < 0.7 ? vec3(0, n.z, -n.y) : vec3(-n.z, 0, n.x));
    vec3 along = s.radius * e, beside = s.radius * cross(n, e);
    float least = s.radius;
    const float needle = 0;
#endif
    vec2 focal = vec2(frame.focal[0], frame.focal[1]), c = vec2(frame.center[0], frame.center[1]);
    float facing = ORTHOGRAPHIC ? abs(n.z) : abs(dot(n, s.center)) / dot(s.center, s.center);
    float thin = least * min(focal.x, focal.y) * facing;
    float wide = min(WIDE + SNAP / thin + needle, WIDEST);
    vec3 p = s.center + wide * (turn.x * along + turn.y * beside);
    if (ORTHOGRAPHIC)
        return to_clip(c + focal * p.xy, 0.5, 1);
    return to_clip(c * p.z + focal * p.xy, BEFORE * frame.near_depth, p.z);
}

vec4 ellipse_vertex(Footprint f, vec2 turn)
{
    vec2 d = turn * inversesqrt(f.q.xz);
    d.x -= f.q.y * d.y;
    return to_clip(place_position(f.p) + WIDE * d, 0.5, 1);
}

#ifdef BLENDED
// ZP Eq. 6. Slabs of the groups are shifted against each other, so that their seams do not meet. What is
// transparent has slabs of its object's epsilon; what is opaque, of the least: nothing behind may keep
// it out.
vec4 slabs_of(float depth, bool opaque, float epsilon)
{
    float thick = HAS_OBJECTS && !opaque ? epsilon * frame.slab_scale : 1, scale = frame.slab_scale / thick;
    return vec4((depth - frame.depth_low) * scale + push_shift, scale, thick, frame.raster_slab);
}
#endif

void main()
{
    uint index = gl_VertexIndex / 3, corner = gl_VertexIndex % 3;
#ifdef ORDERED
    uint id = frame.order.v[push_first + index];
#else
    uint id = index;
#endif
    Splat s;
    // Radius 0: a lane that has no vertex.
    bool floored, seen = splat_load(id, s) && s.radius > 0;
#ifdef BLENDED
    s.radius *= push_factor;
    // The object of the splat as it was loaded: where it was loaded once more for the tag alone, Mesa
    // 22.3 on a CPU gave another of its words, and the material was looked up far outside.
    MaterialData material = material_at(s.tag >> 8);
    vec3 albedo = HAS_COLOR ? frame.colors.v[id] : material.albedo;
    vary_color = vec4(SHADED_ONCE ? shade(material, albedo, s.normal, vec2(0), 0) : albedo,
                      splat_opacity(id));
#endif
    Footprint f = footprint_make(s, floored);
    vec2 turn = vec2(corner == 0 ? 1.0 : -0.5, corner == 0 ? 0 : corner == 1 ? 0.8660254 : -0.8660254);
    gl_Position = floored ? ellipse_vertex(f, turn) : disc_vertex(s, turn);
    if (!seen)
        gl_Position = NO_VERTEX;
#ifdef LAYERS
    gl_Layer = int(splat_group(s));
#endif
#if defined(WITH_PHONG)
    const uint encoded = 0;
#elif defined(BLENDED)
    uint encoded = PACKED ? octahedral_encode(s.normal, WINNER_NORMAL_BITS) << 8 : 0;
    vary_slabs = slabs_of(f.zc, MIXED && vary_color.w == 1, material.epsilon);
    if (PACKED)
        vary_rho_scale = WINNER_RHO * push_factor * push_factor; // as if the radius were not enlarged
#else
    uint encoded = PACKED ? normal_encode(s.normal) : 0;
#endif
    vary_words = uvec4(id, encoded, f.p.whole - ivec2(frame.tile_x, frame.tile_y));
    vary_a = vec4(f.p.part, f.zc, f.g);
    vary_b = vec4(f.ab, f.h);
    vary_c = vec4(f.q, f.reach);
    if (splat_clipped(s, floored))
        vary_clipped(s);
    vary_normal = s.normal;
#ifdef WITH_PHONG
    Phong e = s.phong;
    vary_st = f.st;
    vary_field = s.normal + e.side * (e.field.x * e.u + e.field.z * e.v);
    vary_field_s = e.side * e.field.y * e.u;
    vary_field_t = e.side * e.field.w * e.v;
#endif
}
