#version 460
#extension GL_GOOGLE_include_directive : require
// One walk's splats on blocks of pixels, front to back. A thread takes a column of its block and holds
// the sums of its pixels in registers: a splat is fetched once for eight pixels. A part takes
// STP_AXIS_PART entries at most, since a device may stop long loops; later parts go on.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
#include "lib/axis.glsl"
#include "lib/ellipsoid.glsl"
layout(local_size_x = STP_GROUP) in;

const float DARK = 1.0 / 16777216; // what light is left then changes no float

uint sum_index(uint block, uint column, uint row)
{
    return 2 * ((AXIS_WALK * frame.blocks_x * frame.blocks_y + block) * STP_GROUP +
                row * STP_BLOCK + column);
}

void main()
{
    uint block = workgroup_index() * (STP_GROUP / STP_BLOCK) + gl_LocalInvocationIndex / STP_BLOCK;
    uint column = gl_LocalInvocationIndex % STP_BLOCK;
    if (block >= frame.blocks_x * frame.blocks_y)
        return;
    uvec2 p = uvec2(block % frame.blocks_x, block / frame.blocks_x) * STP_BLOCK +
              uvec2(frame.tile_x + column, frame.tile_y);
    uint list = (AXIS_WALK * frame.axis.blocks_y + p.y / STP_BLOCK) * frame.axis.blocks_x +
                p.x / STP_BLOCK;
    uint first = frame.counts.v[list], done = AXIS_PART * STP_AXIS_PART;
    uint count = frame.counts.v[list + 1] - first;
    Ray ray[STP_BLOCK];
    vec4 color[STP_BLOCK]; // w: what light is left
    float depth_sum[STP_BLOCK], left = 1;
    [[unroll]] for (uint i = 0; i < STP_BLOCK; i++) {
        ray[i] = axis_ray(vec2(p.x, p.y + i) + 0.5);
        uint from = sum_index(block, column, i);
        color[i] = AXIS_PART > 0 ? frame.axis_sums.v[from] : vec4(0, 0, 0, 1);
        depth_sum[i] = AXIS_PART > 0 ? frame.axis_sums.v[from + 1].x : 0;
    }
    uint turns = done < count ? min(count - done, STP_AXIS_PART) : 0, next = first + count - done;
    for (uint n = 0; n < turns && left > DARK; n++) {
        uint splat = frame.order.v[--next];
        vec3 own;
        vec4 place;
        Ellipsoid ellipsoid;
        if (ELLIPSOIDS) {
            ellipsoid = ellipsoid_load(splat, own);
        } else {
            place = frame.projected.v[2 * splat];
            own = frame.projected.v[2 * splat + 1].xyz;
        }
        left = 0;
        [[unroll]] for (uint i = 0; i < STP_BLOCK; i++) {
            float depth, w = color[i].w;
            w *= ELLIPSOIDS ? ellipsoid_alpha(ellipsoid, ray[i].d, depth)
                            : axis_alpha(ray[i], place.xyz, place.w, depth);
            color[i] += vec4(w * own, -w);
            depth_sum[i] += w * depth;
            left = max(left, color[i].w);
        }
    }
    [[unroll]] for (uint i = 0; i < STP_BLOCK; i++) {
        uint to = sum_index(block, column, i);
        frame.axis_sums.v[to] = color[i];
        frame.axis_sums.v[to + 1] = vec4(depth_sum[i], 0, 0, 0);
    }
}
