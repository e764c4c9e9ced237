#version 460
#extension GL_GOOGLE_include_directive : require
// --voronoi exact, first step: each group's nearest depth of every pixel.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/pixel.glsl"
#define FIRST_PASS

uint splat_encode(uint id, Splat s)
{
    return 0;
}

void fragment_emit(uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    atomicMin(frame.nearest.v[pixel * K + splat_group(s)], depth_order(f.depth));
}

#include "lib/rasterize.glsl"
