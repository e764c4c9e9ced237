// What the splat's vertices hand to its fragments: the footprint, flat; and what else is the same for
// all of them. A software device gathers a constant of the frame block for each lane, at some 35
// instructions, and broadcasts what is flat.
#ifdef FRAGMENT
#define VARY(at) layout(location = at) flat in
#else
#define VARY(at) layout(location = at) flat out
#endif
// A software device stores and sets up each location of each triangle: there are few, and full.
VARY(0) uvec4 vary_words; // id, the normal where PACKED, whole within the tile
VARY(1) vec4 vary_a;      // part, zc, g
VARY(2) vec4 vary_b;      // ab, h
VARY(3) vec4 vary_c;      // q, reach (negative: the near plane cuts the splat; see vary_clipped)
VARY(4) vec3 vary_normal;
#define vary_id      vary_words.x
#define vary_encoded vary_words.y
#ifdef WITH_PHONG
VARY(5) vec4 vary_st;
VARY(6) vec3 vary_field; // the field's normal is vary_field + vary_field_s s + vary_field_t t
VARY(7) vec3 vary_field_s;
VARY(8) vec3 vary_field_t;
#endif
#ifdef BLENDED
VARY(5) vec4 vary_color; // shaded, or the albedo; opacity
VARY(6) vec4 vary_slabs; // where zc is, in slabs; slabs a unit; vary_thick; hardware depth of one
#define vary_thick     vary_slabs.z // over the least; with HAS_OBJECTS
#define vary_rho_scale vary_slabs.z // units of the winner's rho^2; where PACKED, which has one object
#endif

// A splat that the near plane cuts has no footprint; in its place goes what clipped_hit takes. A
// fragment that loaded the splat again would do so for every splat: software devices run both sides
// of a branch.
#ifndef FRAGMENT
void vary_clipped(Splat s)
{
#ifdef WITH_PHONG
    vary_a = vec4(s.center, s.phong.radius.x);
    vary_b = vec4(s.normal, s.phong.radius.y);
    vary_c = vec4(s.phong.u, s.phong.side < 0 ? -2 : -1);
#else
    vary_a = vec4(s.center, s.radius);
    vary_b = vec4(s.normal, 0);
    vary_c = vec4(0, 0, 0, -1);
#endif
}
#else
bool clipped_here(Phong e, uvec2 pixel, out Fragment fragment)
{
    Splat s;
    s.center = vary_a.xyz;
    s.normal = vary_b.xyz;
    s.radius = vary_a.w;
    s.phong = e;
#ifdef WITH_PHONG
    s.phong.radius = vec2(vary_a.w, vary_b.w);
    s.phong.u = vary_c.xyz;
    s.phong.v = (vary_c.w < -1.5 ? -1 : 1) * cross(s.normal, s.phong.u);
#endif
    return clipped_hit(s, pixel, fragment);
}

// Discards where the pixel's ray misses the splat.
Fragment fragment_here()
{
    Footprint f = Footprint(Place(ivec2(vary_words.zw), vary_a.xy), vary_a.w, vary_b.xy, vary_c.xyz, vary_a.z,
                            vary_b.zw, vary_c.w, vec4(0));
    Phong e;
#ifdef WITH_PHONG
    f.st = vary_st;
    clip_load(vary_id, e);
#endif
    Fragment fragment;
    uvec2 at = uvec2(gl_FragCoord.xy), pixel = at + uvec2(frame.tile_x, frame.tile_y);
    PRECISE vec2 d = vec2(ivec2(at) - f.p.whole) + (sample_part(pixel) - f.p.part);
    bool hit = CUTS && f.reach < 0 ? clipped_here(e, pixel, fragment) : footprint_hit(f, e, d, fragment);
    if (!hit)
        discard;
    return fragment;
}

vec3 normal_here(Fragment f)
{
#ifdef WITH_PHONG
    vec3 n = vary_field + vary_field_s * f.st.x + vary_field_t * f.st.y;
    float l = dot(n, n);
    return l >= 1e-12 ? n * inversesqrt(l) : vary_normal;
#else
    return vary_normal;
#endif
}

// Reversed: larger is nearer.
float hardware_depth(float depth)
{
    return ORTHOGRAPHIC ? clamp((frame.raster_near - depth) * frame.raster_scale, 0, 1)
                        : min(1, frame.raster_near / depth);
}
#endif
