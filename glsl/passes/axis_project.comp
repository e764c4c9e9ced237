#version 460
#extension GL_GOOGLE_include_directive : require
// Kernels into the camera frame, lit once, at their centres.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
#include "lib/shade.glsl"
#include "lib/axis.glsl"
#include "lib/ellipsoid.glsl"
layout(local_size_x = STP_GROUP) in;

vec3 decode_normal(uint encoded)
{
    vec2 e = unpackSnorm2x16(encoded);
    vec3 n = vec3(e, 1 - abs(e.x) - abs(e.y));
    float fold = max(-n.z, 0);
    n.xy += vec2(n.x >= 0 ? -fold : fold, n.y >= 0 ? -fold : fold);
    return normalize(n);
}

vec3 turn(vec3 v)
{
    const float r[9] = frame.rotation;
    return vec3(r[0] * v.x + r[1] * v.y + r[2] * v.z, r[3] * v.x + r[4] * v.y + r[5] * v.z,
                r[6] * v.x + r[7] * v.y + r[8] * v.z);
}

// Its colour is as the view sees it.
void project_ellipsoid(uint i)
{
    uint at = STP_ELLIPSOID * i;
    vec4 place = frame.splats.v[at], p = frame.splats.v[at + 2], q = frame.splats.v[at + 3];
    Ellipsoid e;
    e.centre = turn(place.xyz) + vec3(frame.translation[0], frame.translation[1],
                                      frame.translation[2]);
    e.tau = place.w;
    ellipsoid_factor(turn(p.xyz), turn(vec3(p.w, q.xy)), turn(vec3(q.zw, frame.splats.v[at + 4].x)),
                     e);
    ellipsoid_store(i, e, frame.splats.v[at + 1].xyz);
}

void main()
{
    uint i = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex;
    if (i >= frame.axis.splats)
        return;
    if (ELLIPSOIDS) {
        project_ellipsoid(i);
        return;
    }
    vec4 place = frame.splats.v[2 * i], look = frame.splats.v[2 * i + 1];
    vec3 c = turn(place.xyz) + vec3(frame.translation[0], frame.translation[1],
                                    frame.translation[2]);
    vec3 color = look.xyz;
    uint encoded = floatBitsToUint(look.w);
    if (!UNLIT && encoded != STP_NO_NORMAL) {
        vec3 n = turn(decode_normal(encoded));
        if ((ORTHOGRAPHIC ? n.z : dot(n, c)) > 0)
            n = -n;
        color = shade_at(material_at(0), color, n, c);
    }
    frame.projected.v[2 * i] = vec4(c, log2(place.w));
    frame.projected.v[2 * i + 1] = vec4(color, 1); // 1: a kernel, for axis_splat.vert
}
