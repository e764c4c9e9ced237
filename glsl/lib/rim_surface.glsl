// What a pixel shows that was left to the discs of level 0, and that one of them reaches: the mean that
// the push has for it, which follows the surface better than one flat disc, or where there is none the
// disc. Needs lib/push.glsl, lib/rim.glsl, and surface_object.

Surface rim_surface(ivec2 p, vec2 q, ivec2 point, float depth)
{
    Texel t = texel_load(0, point);
    Attributes a = attributes_load(0, point);
    Surface s = Surface(1, t.normal, depth, a.color, t.normal, depth, a.id, 1);
    surface_object = a.object;
    Pushed r = push_from(1, p, q, false);
    // One that lies behind the disc is of another surface.
    if (!texel_valid(texel_load(0, p)) && r.weight > 0 && r.depth <= depth + t.radius &&
        r.depth >= frame.near_depth && r.depth <= frame.far_depth) {
        s = Surface(r.weight, r.normal, r.depth, r.attributes.color, r.disc.normal, r.depth, r.attributes.id,
                    r.count);
        surface_object = r.attributes.object;
    }
    s.albedo /= frame.pyramid_color;
    return s;
}
