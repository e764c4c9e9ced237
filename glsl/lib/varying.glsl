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
#ifdef BLENDED
VARY(7) vec4 vary_color; // shaded, or the albedo; opacity
#endif

#ifdef FRAGMENT
// Discards where the pixel's ray misses the splat.
Fragment fragment_here()
{
    Footprint f = Footprint(Place(vary_whole, vary_a.xy), vary_a.w, vary_b.xy, vary_c.xyz, vary_a.z,
                            vary_b.zw, vary_c.w);
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
        hit = footprint_hit(f, place_offset(f.p, pixel), fragment);
    }
    if (!hit)
        discard;
    return fragment;
}

// Reversed: larger is nearer.
float hardware_depth(float depth)
{
    return ORTHOGRAPHIC ? clamp((frame.raster_near - depth) * frame.raster_scale, 0, 1)
                        : min(1, frame.raster_near / depth);
}
#endif
