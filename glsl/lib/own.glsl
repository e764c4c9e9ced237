// A pixel that keeps its own point: its plane, at the pixel's sample. Needs lib/pyramid.glsl, and
// surface_object.

float own_depth(Texel own, vec2 q)
{
    float depth;
    bool hit = disc_hit(own, q, depth);
    return hit ? max(depth, frame.near_depth) : own.depth;
}

Surface own_surface(Texel own, vec2 q, ivec2 p)
{
    float depth = own_depth(own, q);
    Attributes a = attributes_load(0, p);
    surface_object = a.object;
    return Surface(1, own.normal, depth, a.color, own.normal, depth, a.id, 1);
}
