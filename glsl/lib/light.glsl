// The shading model (docs/numerics.md, "Light").

float power(float x, float shininess)
{
    if (SQUARINGS > 16)
        return x > 0 ? pow(x, shininess) : 0;
    [[unroll]] for (uint i = 0; i < SQUARINGS; i++)
        x *= x;
    return x;
}

vec3 camera_point(vec2 pixel, float depth)
{
    vec2 d = (pixel - vec2(frame.center[0], frame.center[1])) *
             vec2(frame.inv_focal[0], frame.inv_focal[1]);
    return ORTHOGRAPHIC ? vec3(d, depth) : vec3(d, 1) * depth;
}

// A light on the surface itself gives no direction: no diffuse term, as in the reference.
vec3 unit_or_zero(vec3 v)
{
    float length2 = dot(v, v);
    return length2 > 0 ? v * inversesqrt(length2) : vec3(0);
}

vec3 shade_at(MaterialData m, vec3 albedo, vec3 n, vec3 p)
{
    if (HEAD_LIGHT && !LOCAL_VIEWER) {
        float c = max(0, -n.z);
        return albedo * (m.ambient + m.diffuse * c) + m.specular * power(c, m.shininess);
    }
    vec3 color = vec3(0);
    vec3 view = LOCAL_VIEWER && !ORTHOGRAPHIC ? -normalize(p) : vec3(0, 0, -1);
    for (uint i = 0; i < frame.light_count; i++) {
        vec3 at = vec3(frame.lights[i].position[0], frame.lights[i].position[1],
                       frame.lights[i].position[2]);
        vec3 light = vec3(frame.lights[i].color[0], frame.lights[i].color[1],
                          frame.lights[i].color[2]);
        vec3 l = frame.lights[i].positional != 0 ? unit_or_zero(at - p) : at;
        vec3 h = l + view;
        float length2 = dot(h, h);
        float c = length2 > 0 ? max(0, dot(n, h) * inversesqrt(length2)) : 0;
        color += light * (albedo * (m.ambient + m.diffuse * max(0, dot(n, l))) +
                          m.specular * power(c, m.shininess));
    }
    return color;
}

vec3 shade(MaterialData m, vec3 albedo, vec3 n, vec2 pixel, float depth)
{
    return shade_at(m, albedo, n, camera_point(pixel, depth));
}

// One fragment of a splat; at: its sample, in the picture.
vec3 shade_fragment(uint id, vec3 n, vec2 at, float depth)
{
    uint object = HAS_OBJECTS ? floatBitsToUint(frame.splats.v[2 * id + 1].w) >> 8 : 0;
    MaterialData m = frame.materials.v[object];
    vec3 albedo = m.albedo;
    if (HAS_COLOR)
        albedo = frame.colors.v[id];
    return shade(m, albedo, n, at, depth);
}
