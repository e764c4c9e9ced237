// What a pixel shows that was left to the discs of level 0, and that one of them reaches: the mean that
// the push has for it, which follows the surface better than one flat disc, unless it lies behind the
// disc. Needs lib/push.glsl, lib/rim.glsl, lib/shade.glsl and surface_object.

// Depth of what the push left in the picture; infinite: nothing, or samples, which add up.
float rim_mean(uvec2 pixel)
{
    return SAMPLE_GRID > 1 ? NOTHING : frame.out_depth.v[pixel.y * frame.tile_width + pixel.x];
}

// The disc, or, of one of several samples, the mean; `bare`: the pixel has no point of its own.
Surface rim_surface(ivec2 p, vec2 q, bool bare, ivec2 point, float depth)
{
    Texel t = texel_load(0, point);
    Attributes a = attributes_load(0, point);
    Surface s = Surface(1, t.normal, depth, a.color, t.normal, depth, a.id, 1);
    surface_object = a.object;
    if (SAMPLE_GRID > 1 && bare) {
        Pushed r = push_from(1, p, q, false);
        if (r.weight > 0 && r.depth <= depth + t.radius && r.depth >= frame.near_depth &&
            r.depth <= frame.far_depth) {
            s = Surface(r.weight, r.normal, r.depth, r.attributes.color, r.disc.normal, r.depth,
                        r.attributes.id, r.count);
            surface_object = r.attributes.object;
        }
    }
    s.albedo /= frame.pyramid_color;
    return s;
}

// Where no disc reaches the pixel it shows nothing.
void rim_write(ivec2 p, uvec2 pixel, bool bare, bool reached, ivec2 point, float depth)
{
    surface_write(pixel, reached, rim_surface(p, rim_position(uvec2(p)), bare, point, depth));
}
