// Where a host's image meets the picture. Before common.glsl.
#define PUSH_MORE STP_PUSH_HOST
#include "lib/common.glsl"

// The host's depth at a pixel of its image inside of the tile's part, as it was copied.
float host_depth(ivec2 at)
{
    ivec2 p = at - push_low;
    uint index = uint(p.y * (push_high.x - push_low.x) + p.x);
    if (HOST_DEPTH == 3) {
        uint pair = frame.host_words.v[index / 2];
        return float((index & 1) == 0 ? pair & 0xffffu : pair >> 16) / 65535.0;
    }
    uint word = frame.host_words.v[index];
    return HOST_DEPTH == 2 ? float(word & 0xffffffu) / 16777215.0 : uintBitsToFloat(word);
}
