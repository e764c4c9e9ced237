// Bounds of the part of a disc that lies beyond the near plane: quotients of the intervals that hold
// x, y and z there. Perspective only.

vec2 quotient(vec2 a, vec2 z) // z > 0
{
    return vec2(a.x / (a.x < 0 ? z.x : z.y), a.y / (a.y < 0 ? z.y : z.x));
}

ivec4 clipped_pixels(Splat s)
{
    vec3 e = PHONG != 0 ? phong_reach(s.phong) : s.radius * sqrt(max(vec3(0), 1 - s.normal * s.normal));
    vec3 low = s.center - e, high = s.center + e;
    vec2 z = vec2(max(low.z, frame.near_depth), high.z);
    vec2 x = quotient(vec2(low.x, high.x), z), y = quotient(vec2(low.y, high.y), z);
    vec2 focal = vec2(frame.focal[0], frame.focal[1]), c = vec2(frame.center[0], frame.center[1]);
    vec4 box = c.xyxy + focal.xyxy * vec4(x.x, y.x, x.y, y.y);
    vec2 slack = 1 + 1e-5 * (abs(box.xy) + abs(box.zw));
    return pixels_of(clamp(box + vec4(-slack, slack), vec4(-1e8), vec4(1e8)));
}
