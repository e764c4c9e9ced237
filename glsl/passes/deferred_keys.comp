#version 460
#extension GL_GOOGLE_include_directive : require
// ZP Algorithm 1, geometry pass, as keys: each group keeps its winning fragment of every pixel.
#include "lib/common.glsl"
#extension GL_EXT_shader_atomic_int64 : require
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#include "lib/key.glsl"
#define FIRST_PASS

uint splat_encode(uint id, Splat s)
{
    return PACKED && PHONG == 0 ? normal_encode(s.normal) : 0;
}

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    uint layer = pixel * K + splat_group(s);
    if (VORONOI == 2 && f.depth > depth_ordered(frame.nearest.v[layer]) + frame.epsilon)
        return;
    uint64_t key = PACKED ? key_packed(f, fragment_encode(s, f, encoded)) : key_id(f, id);
    atomicMin(frame.keys.v[layer], key);
}

#include "lib/rasterize.glsl"
