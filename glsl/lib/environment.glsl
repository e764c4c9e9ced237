#ifndef ENVIRONMENT_GLSL
#define ENVIRONMENT_GLSL
// The environment from a direction (docs/glass.md, "Directions" and "Levels").

vec3 environment_row(uint at, uint width, float x)
{
    float left = floor(x);
    uint i = uint(int(left) + int(width)) % width, next = i + 1 == width ? 0 : i + 1;
    return mix(frame.environment.v[at + i], frame.environment.v[at + next], x - left);
}

// Row 0 and row height + 1 are the poles, half a texel beyond the rows beside them. place: the
// longitude in turns from the map's left edge, the polar angle in half turns.
vec3 environment_level(uint level, vec2 place)
{
    uint width = frame.environment_levels[level].width;
    float height = float(frame.environment_levels[level].height);
    float y = place.y * height + 0.5;
    y = y < 1 ? 2 * y - 1 : y > height ? 2 * y - height : y;
    float row = clamp(floor(y), 0, height), x = place.x * float(width) - 0.5;
    uint at = frame.environment_levels[level].first + uint(row) * width;
    return mix(environment_row(at, width, x), environment_row(at + width, width, x), y - row);
}

// d: unit, camera frame.
vec3 environment_at(vec3 d, float level)
{
    const float m[9] = frame.environment_frame;
    vec3 e = vec3(dot(vec3(m[0], m[1], m[2]), d), dot(vec3(m[3], m[4], m[5]), d),
                  dot(vec3(m[6], m[7], m[8]), d));
    float across = length(e.xz);
    const float turn = 0.15915494309189535;
    vec2 place = vec2(across > 0 ? atan(e.x, e.z) * turn + 0.5 : 0.5, atan(across, e.y) * (2 * turn));
    uint first = (OPTICS & STP_OPTICS_ROUGH) != 0 ? uint(max(level, 0)) : 0;
    vec3 light = environment_level(first, place);
    if ((OPTICS & STP_OPTICS_BETWEEN) != 0 && level > float(first))
        light = mix(light, environment_level(first + 1, place), level - float(first));
    return light;
}

// Along the ray of a picture position.
vec3 ray_direction(vec2 pixel)
{
    vec2 d = (pixel - vec2(frame.center[0], frame.center[1])) *
             vec2(frame.inv_focal[0], frame.inv_focal[1]);
    return ORTHOGRAPHIC ? vec3(0, 0, 1) : normalize(vec3(d, 1));
}

// What is behind everything, premultiplied.
vec4 background_at(vec2 pixel)
{
    if ((OPTICS & STP_OPTICS_BEHIND) != 0)
        return vec4(environment_at(ray_direction(pixel), 0), 1);
    return vec4(frame.background[0], frame.background[1], frame.background[2], frame.background[3]);
}
#endif
