// Discs of points as they are, round about pixels that the push left empty. Needs lib/pyramid.glsl.
#include "lib/reach.glsl"

// Pixels by which the disc is widened. Where discs are small on the screen, seen flat above all, several
// points fall into a pixel and one stands for all: its disc has to reach where theirs would. An area of
// 16 pixels is what a point has when one pixel in four holds one, at the usual radius (spacing).
float disc_crowd(Texel t)
{
    float scale = ORTHOGRAPHIC ? 1 : 1 / t.depth, facing = abs(t.normal.z);
    if (!ORTHOGRAPHIC) {
        vec2 inverse = vec2(frame.inv_focal[0], frame.inv_focal[1]);
        vec3 ray = vec3((t.center - vec2(frame.center[0], frame.center[1])) * inverse, 1);
        facing = abs(dot(t.normal, ray)) * inversesqrt(dot(ray, ray));
    }
    PRECISE float r = t.radius * scale, area = 3.14159 * r * r * frame.focal[0] * frame.focal[1] * facing;
    return MOST_CROWD * clamp((16 - area) / 12, 0, 1);
}

// Of the picture's sample in pixel p of the grid.
vec2 rim_position(uvec2 p)
{
    ivec2 pixel = ivec2(p) + ivec2(frame.grid_x, frame.grid_y);
    return vec2(pixel) + (sample_part(uvec2(pixel)) - sample_shift());
}

// How far from its centre the disc reaches on the screen, at most; pixels.
vec2 disc_reach(Texel t)
{
    vec2 focal = vec2(frame.focal[0], frame.focal[1]);
    float nearest = ORTHOGRAPHIC ? 1 : max(t.depth - t.radius, 0.5 * t.depth);
    return max(t.radius * focal / nearest, vec2(frame.pyramid_floor));
}

// Pixels of the grid that it may touch, STP_RIM_REACH from its centre at most. False: none.
bool disc_box(Texel t, out ivec4 box)
{
    vec2 at = t.center - vec2(frame.grid_x, frame.grid_y);
    vec2 r = min(disc_reach(t) + 0.5, vec2(STP_RIM_REACH));
    vec2 last = vec2(frame.grid_width, frame.grid_height) - 1;
    box = ivec4(clamp(floor(at - r), vec2(0), last), clamp(floor(at + r), vec2(0), last));
    return all(greaterThanEqual(at + r, vec2(0))) && all(lessThan(at - r, last + 1));
}

// Open pixels come in words of 8 x 4: those that a box of pixels touches, and of one such word those in
// the box.
uvec4 box_words(ivec4 box)
{
    return uvec4(box) / uvec4(STP_BLOCK, STP_BLOCK / 2, STP_BLOCK, STP_BLOCK / 2);
}

uint word_bits(uvec2 word, ivec4 box)
{
    ivec2 corner = ivec2(word) * ivec2(STP_BLOCK, STP_BLOCK / 2);
    uvec2 first = uvec2(max(box.xy - corner, ivec2(0)));
    uvec2 last = uvec2(min(box.zw - corner, ivec2(STP_BLOCK - 1, STP_BLOCK / 2 - 1)));
    uint row = (0xffu >> (STP_BLOCK - 1 - last.x)) & (0xffu << first.x);
    uint rows = (0xffffffffu >> (STP_BLOCK * (STP_BLOCK / 2 - 1 - last.y))) & (0xffffffffu << (STP_BLOCK * first.y));
    return (row * 0x01010101u) & rows;
}

// OPEN_GROWS: threads of the same dispatch open pixels.
uint open_bits(uvec2 word, ivec4 box)
{
    uint block = word.y / 2 * (frame.grid_width / STP_BLOCK) + word.x;
#ifdef OPEN_GROWS
    return ATOMIC_LOAD(frame.work.v[open_word(block, word.y % 2)]) & word_bits(word, box);
#else
    return frame.work.v[open_word(block, word.y % 2)] & word_bits(word, box);
#endif
}

// The disc at an empty pixel; `crowd`: it stands for others of its pixel, whose centres may lie so much
// nearer.
bool rim_hit(Texel t, float crowd, vec2 q, out float depth)
{
    PRECISE vec2 d = t.center - q;
    PRECISE float away = sqrt(inner(d, d));
    PRECISE vec2 at = q + d * (min(crowd, away) / max(away, 1e-6));
    bool hit = disc_hit(t, at, depth);
    return hit && depth >= frame.near_depth && depth <= frame.far_depth;
}
