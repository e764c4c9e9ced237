// The pixels that a splat may touch, and whether a plane cuts it. Included by splat.glsl.

// How far the disc reaches along the depth axis.
float splat_depth_reach(Splat s)
{
    if (PHONG != 0)
        return phong_reach(s.phong).z;
    return s.radius * sqrt(max(0, 1 - s.normal.z * s.normal.z));
}

bool splat_crosses_near(Splat s)
{
    return !(s.center.z - splat_depth_reach(s) > frame.near_depth);
}

// Bounds and hits are those of clipped.glsl and clipped_hit.
bool splat_clipped(Splat s, bool floored)
{
    return CUTS && !ORTHOGRAPHIC && !floored && splat_crosses_near(s);
}

bool splat_before_near(Splat s)
{
    return CUTS && s.center.z + splat_depth_reach(s) < frame.near_depth;
}

// Offsets from the projected centre that the outline reaches; for splats before no plane.
vec4 footprint_extent(Splat s, Footprint f, bool floored)
{
    vec2 focal = vec2(frame.focal[0], frame.focal[1]);
    if (floored) {
        vec2 e = sqrt(vec2(1 / f.q.x + f.q.y * f.q.y / f.q.z, 1 / f.q.z));
        return vec4(-e, e);
    }
    vec3 n = s.normal;
    if (PHONG != 0 && !ORTHOGRAPHIC)
        return focal.xyxy * phong_extent(s.phong, s.center.z, splat_direction(s));
    if (ORTHOGRAPHIC) {
        vec2 e = PHONG != 0 ? focal * phong_reach(s.phong).xy : s.radius * focal * sqrt(max(vec2(0), 1 - n.xy * n.xy));
        return vec4(-e, e);
    }
    // Tangent lines of the projected conic: det(q) = (alpha g / fx fy)^2 cancels (docs/deferred.md).
    vec2 d = splat_direction(s);
    float alpha = s.center.z / s.radius, m = dot(n.xy, n.xy), k = 1 / (alpha * alpha - m);
    vec2 mid = (d * m + n.xy * n.z) * k;
    vec2 e = n.xy * d + n.z;
    vec2 reach = sqrt(mid * mid + (e * e + n.yx * n.yx * (1 + d * d)) * k);
    return vec4(focal * (mid - reach), focal * (mid + reach));
}

// Pixel rectangle [xy, zw] within the tile, a thousandth of a pixel wider than the outline. Samples
// may lie anywhere in a pixel.
ivec4 pixels_of(vec4 box)
{
    if (SAMPLE_GRID > 1)
        box += vec4(-0.5, -0.5, 0.5, 0.5);
    vec2 low = vec2(frame.tile_x, frame.tile_y);
    vec2 high = low + vec2(frame.tile_width, frame.tile_height) - 1;
    vec2 from = max(ceil(box.xy - 0.5 - 1e-3), low), to = min(floor(box.zw - 0.5 + 1e-3), high);
    // Empty boxes, and NaN, come out as from > to.
    return all(lessThanEqual(from, to)) ? ivec4(from, to) : ivec4(0, 0, -1, -1);
}

ivec4 footprint_pixels(Splat s, Footprint f, bool floored)
{
    return pixels_of(footprint_extent(s, f, floored) + place_position(f.p).xyxy);
}

// Whether a thread may draw the splat alone: its pixels are few and no plane cuts it.
bool bounds_small(Splat s, bool floored, ivec4 box)
{
    // In float: the product may exceed an int only where it is large anyway.
    float area = float(box.z - box.x + 1) * float(box.w - box.y + 1);
    return !splat_clipped(s, floored) && area <= float(BINS ? STP_BIN_AREA : STP_LARGE_AREA);
}

bool splat_small(Splat s, out bool floored, out ivec4 box)
{
    Footprint f = footprint_make(s, floored);
    box = footprint_pixels(s, f, floored);
    return bounds_small(s, floored, box);
}
