// A pixel that keeps its own point: its plane, at the pixel's sample. Needs lib/pyramid.glsl, and
// surface_object.

Surface own_surface(Texel own, vec2 q, ivec2 p)
{
    float depth;
    bool hit = disc_hit(own, q, depth);
    depth = hit ? max(depth, frame.near_depth) : own.depth;
    Attributes a = attributes_load(0, p);
    surface_object = a.object;
    return Surface(1, own.normal, depth, a.color, own.normal, depth, a.id, 1);
}
