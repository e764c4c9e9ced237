// Bounds of a disc cut by the near plane: the arc's tangent points and the chord's ends.

void include_point(inout vec4 box, vec3 p)
{
    vec2 focal = vec2(frame.focal[0], frame.focal[1]), c = vec2(frame.center[0], frame.center[1]);
    vec2 q = c + focal * p.xy / p.z;
    box = vec4(min(box.xy, q), max(box.zw, q));
}

// Extrema of coordinate x / z over the circle c + r (e cos t + f sin t), where f.z = 0.
void include_tangents(inout vec4 box, Splat s, vec3 e, vec3 f, int axis)
{
    float r = s.radius, reach = r * e.z;
    float a = reach * s.center[axis] - r * e[axis] * s.center.z;
    float b = r * f[axis] * s.center.z, c = r * reach * f[axis];
    float l = sqrt(a * a + b * b);
    if (!(l > 0) || abs(c) > l)
        return;
    float mid = atan(a, b), turn = acos(clamp(-c / l, -1, 1));
    for (int i = 0; i < 2; i++) {
        float t = i == 0 ? mid + turn : mid - turn;
        vec3 p = s.center + r * (cos(t) * e + sin(t) * f);
        if (p.z >= frame.near_depth)
            include_point(box, p);
    }
}

// Perspective only; the splat reaches past the near plane on both sides.
ivec4 clipped_pixels(Splat s)
{
    float m = sqrt(max(1e-20, 1 - s.normal.z * s.normal.z));
    vec3 e = (vec3(0, 0, 1) - s.normal.z * s.normal) / m, f = cross(s.normal, e);
    f.z = 0;
    vec4 box = vec4(1e30, 1e30, -1e30, -1e30);
    float c = clamp((frame.near_depth - s.center.z) / (s.radius * m), -1, 1), si = sqrt(1 - c * c);
    include_point(box, s.center + s.radius * e);
    vec3 chord = s.center + s.radius * c * e;
    chord.z = frame.near_depth;
    include_point(box, chord + s.radius * si * f);
    include_point(box, chord - s.radius * si * f);
    include_tangents(box, s, e, f, 0);
    include_tangents(box, s, e, f, 1);
    vec2 slack = 1 + 1e-4 * (box.zw - box.xy);
    return pixels_of(clamp(box + vec4(-slack, slack), vec4(-1e8), vec4(1e8)));
}
