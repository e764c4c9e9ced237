#version 460
#extension GL_GOOGLE_include_directive : require
// A surface's splats onto the screen, each lit once, at its centre.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/shade.glsl"
#include "lib/gaussian.glsl"
layout(local_size_x = STP_GROUP) in;

// In front of the near plane: from the footprint, whose offsets are from the projected centre.
void place_footprint(Footprint f, bool floored, inout Gaussian g)
{
    g.at = clamp(f.p.whole, ivec2(0), ivec2(frame.width, frame.height) - 1);
    vec2 off = vec2(g.at - f.p.whole) + (0.5 - f.p.part);
    if (PHONG != 0) {
        g.s.xy = vec2(f.st.x, f.st.x * f.q.y + f.st.z);
        g.t.xy = vec2(f.st.y, f.st.y * f.q.y + f.st.w);
    } else {
        g.s.xy = sqrt(f.q.x) * vec2(1, f.q.y);
        g.t.xy = vec2(0, sqrt(f.q.z));
    }
    if (ORTHOGRAPHIC || floored) { // nothing is left to divide by
        g.s.xy /= f.g;
        g.t.xy /= f.g;
        g.v = vec3(f.h / f.g, f.zc + dot(f.h / f.g, off));
        g.depth = f.zc + vec2(-f.reach, f.reach);
    } else {
        g.v = vec3(f.ab, f.g + dot(f.ab, off));
        g.depth = vec2(f.zc * f.g, -1);
    }
    g.s.z = dot(g.s.xy, off);
    g.t.z = dot(g.t.xy, off);
}

// Across the near plane: from the ray's meeting with the plane, around the middle of the picture.
void place_plane(Splat s, inout Gaussian g)
{
    vec3 n = s.normal, u, v;
    vec2 radius = vec2(s.radius);
    if (PHONG != 0) {
        u = s.phong.u;
        v = s.phong.v;
        radius = s.phong.radius;
    } else {
        u = normalize(abs(n.x) < 0.7 ? vec3(0, n.z, -n.y) : vec3(-n.z, 0, n.x));
        v = cross(n, u);
    }
    g.at = ivec2(frame.width, frame.height) / 2;
    vec2 inv = vec2(frame.inv_focal[0], frame.inv_focal[1]);
    vec2 ray = (vec2(g.at) + 0.5 - vec2(frame.center[0], frame.center[1])) * inv;
    float nc = dot(n, s.center);
    // The component along n of the ray of (dx, dy), and of what of u and v the hit is away from c.
    vec3 a = nc * u - dot(u, s.center) * n, b = nc * v - dot(v, s.center) * n;
    g.v = vec3(n.xy * inv, dot(n.xy, ray) + n.z);
    g.s = vec3(a.xy * inv, dot(a.xy, ray) + a.z) / radius.x;
    g.t = vec3(b.xy * inv, dot(b.xy, ray) + b.z) / radius.y;
    g.depth = vec2(nc, -1);
}

void main()
{
    uint index = workgroup_index() * STP_GROUP + gl_LocalInvocationIndex;
    uint id = splat_known(index); // loads are not always masked, and objects are followed
    Splat s;
    Gaussian g;
    bool floored, seen = splat_load(id, s);
    Footprint f = footprint_make(s, floored);
    if (splat_clipped(s, floored))
        place_plane(s, g);
    else
        place_footprint(f, floored, g);
    g.opacity = !seen ? 0 : OPACITY == 0 ? 1 : splat_opacity(id);
    vec3 n = s.normal;
    if (PHONG != 0)
        n = phong_normal(s.phong, s.normal, vec2(0));
    MaterialData m = material_at(s.tag >> 8);
    vec3 albedo = m.albedo;
    if (HAS_COLOR)
        albedo = frame.colors.v[id];
    g.color = shade_at(m, albedo, n, s.center);
    g.clip[0] = s.phong.clip[0];
    g.clip[1] = s.phong.clip[1];
    g.reflex = s.phong.reflex;
    if (index < frame.axis.splats)
        gaussian_store(id, g);
}
