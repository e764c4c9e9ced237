#version 460
#extension GL_GOOGLE_include_directive : require
// BSK 4.1: what the lights give to each normal, of the camera frame: their diffuse and their specular
// sums. The order of the faces is +x -x +y -y +z -z.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
#include "lib/light.glsl"
layout(local_size_x = STP_GROUP) in;

vec3 texel_normal(uint texel)
{
    uint face = texel / (STP_LIGHT_CUBE * STP_LIGHT_CUBE), in_face = texel % (STP_LIGHT_CUBE * STP_LIGHT_CUBE);
    vec2 at = vec2(in_face % STP_LIGHT_CUBE, in_face / STP_LIGHT_CUBE) * (2.0 / (STP_LIGHT_CUBE - 1)) - 1;
    float side = face % 2 == 0 ? 1 : -1;
    vec3 n = face < 2 ? vec3(side, at) : face < 4 ? vec3(at.y, side, at.x) : vec3(at, side);
    return normalize(n);
}

void main()
{
    uint texel = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex;
    if (texel >= 6 * STP_LIGHT_CUBE * STP_LIGHT_CUBE)
        return;
    // Materials of one: the sums apart. Every object has the first one's shininess.
    MaterialData matt = MaterialData(0, 1, 0, 1, vec3(1), 0);
    MaterialData shiny = MaterialData(0, 0, 1, frame.material.shininess, vec3(0), 0);
    vec3 n = texel_normal(texel);
    frame.light_cube.v[2 * texel] = lights_at(matt, vec3(1), n, vec3(0));
    frame.light_cube.v[2 * texel + 1] = lights_at(shiny, vec3(0), n, vec3(0));
}
