// Where a host's image meets the picture. Before common.glsl: struct pass_host_push. Pixels of the
// host's image: where the picture's corner is, and the part that this tile covers. Hardware depth =
// add + scale / Z (orthographic: * Z), none where nothing is; the largest finite value of the colour
// format; whether pixels without a surface are written too.
#define PUSH_MORE                                                                                  \
    ivec2 push_corner;                                                                             \
    ivec2 push_low;                                                                                \
    ivec2 push_high;                                                                               \
    float push_add;                                                                                \
    float push_scale;                                                                              \
    float push_none;                                                                               \
    float push_most;                                                                               \
    uint push_replace;
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
