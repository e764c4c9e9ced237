// From pixels of the picture, times w, to clip space. The tile is `guard` of it, so that splats that
// cross its border are not clipped, but left out by the scissor (pass_guard).
vec4 to_clip(vec2 pixel, float z, float w)
{
    vec2 size = vec2(frame.tile_width, frame.tile_height);
    vec2 ndc = (pixel - w * vec2(frame.tile_x, frame.tile_y)) * 2 / size - w;
    return vec4(ndc * frame.guard, z, w);
}
