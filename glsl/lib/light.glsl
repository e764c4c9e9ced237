// The shading model (docs/numerics.md, "Light").
#include "lib/precise.glsl"

PRECISE float power(float x, float shininess)
{
    if (SQUARINGS > 16)
        return x > 0 ? pow(x, shininess) : 0;
    [[unroll]] for (uint i = 0; i < SQUARINGS; i++)
        x *= x;
    return x;
}

PRECISE vec3 camera_point(vec2 pixel, float depth)
{
    vec2 d = (pixel - vec2(frame.center[0], frame.center[1])) *
             vec2(frame.inv_focal[0], frame.inv_focal[1]);
    return ORTHOGRAPHIC ? vec3(d, depth) : vec3(d, 1) * depth;
}

// A light on the surface itself gives no direction: no diffuse term, as in the reference.
PRECISE vec3 unit_or_zero(vec3 v)
{
    PRECISE float length2 = inner(v, v);
    return length2 > 0 ? v * inversesqrt(length2) : vec3(0);
}

// The sum over lights.
PRECISE vec3 lights_at(MaterialData m, vec3 albedo, vec3 n, vec3 p)
{
    vec3 color = vec3(0);
    vec3 view = LOCAL_VIEWER && !ORTHOGRAPHIC ? -unit_or_zero(p) : vec3(0, 0, -1);
    for (uint i = 0; i < frame.light_count; i++) {
        vec3 at = vec3(frame.lights[i].position[0], frame.lights[i].position[1],
                       frame.lights[i].position[2]);
        vec3 light = vec3(frame.lights[i].color[0], frame.lights[i].color[1],
                          frame.lights[i].color[2]);
        vec3 l = frame.lights[i].positional != 0 ? unit_or_zero(at - p) : at;
        vec3 h = l + view;
        PRECISE float length2 = inner(h, h);
        PRECISE float c = length2 > 0 ? max(0, inner(n, h) * inversesqrt(length2)) : 0;
        color += light * (albedo * (m.ambient + m.diffuse * max(0, inner(n, l))) +
                          m.specular * power(c, m.shininess));
    }
    return color;
}

// Of a unit normal: where in the cube, and what is between four texels there.
void cube_place(vec3 n, out uint corner, out vec2 part)
{
    vec3 a = abs(n);
    float most = max(a.x, max(a.y, a.z));
    uint axis = a.x == most ? 0 : a.y == most ? 1 : 2;
    PRECISE vec2 at = (axis == 0 ? n.yz : axis == 1 ? n.zx : n.xy) / most;
    uint face = 2 * axis + (n[axis] < 0 ? 1 : 0);
    PRECISE vec2 place = (at + 1) * (0.5 * (STP_LIGHT_CUBE - 1)), low = min(floor(place), float(STP_LIGHT_CUBE - 2));
    corner = (face * STP_LIGHT_CUBE + uint(low.y)) * STP_LIGHT_CUBE + uint(low.x);
    part = place - low;
}

PRECISE vec3 cube_read(uint corner, vec2 part, uint term)
{
    vec3 a = between(frame.light_cube.v[2 * corner + term], frame.light_cube.v[2 * corner + 2 + term], part.x);
    uint below = 2 * (corner + STP_LIGHT_CUBE) + term;
    return between(a, between(frame.light_cube.v[below], frame.light_cube.v[below + 2], part.x), part.y);
}

PRECISE vec3 cube_light(MaterialData m, vec3 albedo, vec3 n)
{
    uint corner;
    vec2 part;
    vec3 ambient = vec3(0);
    for (uint i = 0; i < frame.light_count; i++)
        ambient += vec3(frame.lights[i].color[0], frame.lights[i].color[1], frame.lights[i].color[2]);
    cube_place(n, corner, part);
    return albedo * (m.ambient * ambient + m.diffuse * cube_read(corner, part, 0)) +
           m.specular * cube_read(corner, part, 1);
}

PRECISE vec3 shade_at(MaterialData m, vec3 albedo, vec3 n, vec3 p)
{
    if (HEAD_LIGHT && !LOCAL_VIEWER) {
        float c = max(0, -n.z);
        return albedo * (m.ambient + m.diffuse * c) + m.specular * power(c, m.shininess);
    }
    if (LIGHT_CUBE)
        return cube_light(m, albedo, n);
    return lights_at(m, albedo, n, p);
}

PRECISE vec3 shade(MaterialData m, vec3 albedo, vec3 n, vec2 pixel, float depth)
{
    return shade_at(m, albedo, n, camera_point(pixel, depth));
}

// One fragment of a splat; at: its sample, in the picture.
PRECISE vec3 shade_fragment(uint id, vec3 n, vec2 at, float depth)
{
    uint object = HAS_OBJECTS ? floatBitsToUint(frame.splats.v[2 * id + 1].w) >> 8 : 0;
    MaterialData m = material_at(object);
    vec3 albedo = m.albedo;
    if (HAS_COLOR)
        albedo = frame.colors.v[id];
    return shade(m, albedo, n, at, depth);
}
