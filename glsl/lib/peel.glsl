// Depth peeling (ZP 2, 6.2): the two-pass method draws a transparent scene a layer at a time. What is
// peeled of a ray ends at frame.nearest.
const bool PEEL = OPACITY != 0;

// An opaque splat belongs to no transparent layer, and is not peeled with one: it ends the ray, which
// frame.limits knows beforehand. What is transparent at or behind it belongs to no layer at all.
bool peeled(uint pixel, uint id, float depth)
{
    if (!PEEL)
        return false;
    float end = uintBitsToFloat(frame.nearest.v[pixel]);
    if (splat_opaque(id))
        return isinf(end) && end > 0;
    return depth <= end || (MIXED && depth_order(depth) >= frame.limits.v[pixel]);
}

// Peeled, or not of one kind with the nearest splat of the layer at hand.
bool peel_other(uint pixel, uint id, float depth, uint nearest)
{
    return peeled(pixel, id, depth) || (MIXED && splat_opaque(id) != splat_opaque(nearest));
}

#ifdef RESOLVES
// Puts one more layer behind those that the picture holds, and peels it. Depth and the rest stay the
// first one's.
void peel_write(uvec2 p, uint pixel, bool hit, Surface s, float alpha)
{
    if (!hit)
        return;
    uint i = p.y * frame.tile_width + p.x;
    vec4 before = frame.out_color.v[i];
    bool first = isinf(frame.out_depth.v[i]), opaque = splat_opaque(s.id);
    Look look = surface_look(p, hit, s);
    if (first)
        picture_write(p, hit, vec4(0), look, s, 0);
    float through = 1 - before.w;
    frame.out_color.v[i] = vec4(before.xyz + through * alpha * look.color,
                                opaque ? 1 : before.w + through * alpha);
    if ((AOVS & 4) != 0)
        frame.out_id.v[ID_WORDS * i + ID_WORDS - 1]++;
    frame.nearest.v[pixel] = opaque ? 0x7f800000u : floatBitsToUint(s.near_depth + object_epsilon(s.id));
}
#endif
