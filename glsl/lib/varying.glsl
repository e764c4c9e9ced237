// What the splat's vertices hand to its fragments: the footprint, flat.
#ifdef FRAGMENT
#define VARY(at) layout(location = at) flat in
#else
#define VARY(at) layout(location = at) flat out
#endif
VARY(0) uint vary_id;
VARY(1) vec4 vary_a; // part, zc, g
VARY(5) ivec2 vary_whole;
VARY(2) vec4 vary_b; // ab, h
VARY(3) vec4 vary_c; // q, reach (negative: the disc is clipped)
VARY(4) vec3 vary_normal;
VARY(6) uint vary_encoded; // the normal, PACKED
#ifdef WITH_PHONG
VARY(7) vec4 vary_st;
VARY(8) vec3 vary_field;   // the field's normal is vary_field + vary_field_s s + vary_field_t t
VARY(9) vec3 vary_field_s;
VARY(10) vec3 vary_field_t;
#endif
#ifdef BLENDED
VARY(7) vec4 vary_color; // shaded, or the albedo; opacity
#endif

#ifdef FRAGMENT
// Discards where the pixel's ray misses the splat.
Fragment fragment_here()
{
    Footprint f = Footprint(Place(vary_whole, vary_a.xy), vary_a.w, vary_b.xy, vary_c.xyz, vary_a.z,
                            vary_b.zw, vary_c.w, vec4(0));
    Phong e;
#ifdef WITH_PHONG
    f.st = vary_st;
    clip_load(vary_id, e);
#endif
    Fragment fragment;
    uvec2 pixel = uvec2(gl_FragCoord.xy) + uvec2(frame.tile_x, frame.tile_y);
    bool hit;
    if (f.reach < 0) {
        Splat s;
        splat_load(vary_id, s);
#ifdef BLENDED
        s.radius *= push_factor;
#endif
        hit = clipped_hit(s, pixel, fragment);
    } else {
        hit = footprint_hit(f, e, place_offset(f.p, pixel), fragment);
    }
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
