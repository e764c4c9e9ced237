#version 460
#extension GL_GOOGLE_include_directive : require
// Which blocks have a fragment in any of the K images that were drawn: the others keep what the picture
// starts with. MASK, for ZP Algorithm 3, between its geometry passes: also where the nearest layer of all
// groups ends. A mask of each group by itself would count the first layer twice.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#define ALL_BLOCKS
#define IN_ROWS
#include "lib/resolve.glsl"
layout(set = 0, binding = 1, rg32ui) uniform readonly uimage2DArray winners;

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    bool touched = false;
#ifdef MASK
    float near = 1.0 / 0.0;
    uint id = STP_NO_ID;
#endif
    [[unroll]] for (uint k = 0; k < K; k++) {
        uvec2 winner = imageLoad(winners, ivec3(p, k)).xy;
        touched = touched || winner != uvec2(STP_NO_ID);
#ifdef MASK
        float depth = winner.x == STP_NO_ID ? 1.0 / 0.0 : uintBitsToFloat(winner.y);
        id = depth < near ? winner.x : id;
        near = min(near, depth);
#endif
    }
    if (touched)
        frame.work.v[STP_WORK_FLAGS + pixel / STP_GROUP] = STP_BLOCK_TOUCHED;
#ifdef MASK
    frame.nearest.v[p.y * frame.tile_width + p.x] = floatBitsToUint(near + object_epsilon(id));
#endif
}
