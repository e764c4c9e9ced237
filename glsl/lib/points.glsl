#ifndef POINTS_GLSL
#define POINTS_GLSL
// Points of 16 bytes (MKC 3.1): position relative to the origin, octahedral normal. Fetched as texels,
// which a CPU device loads by the vector, eight points at once, where addresses go one by one.
#include "lib/precise.glsl"
layout(set = 0, binding = STP_BINDING_POINTS) uniform usamplerBuffer point_texels;

// Of any length.
PRECISE vec3 octahedral_unfold(uint u)
{
    vec2 o = unpackSnorm2x16(u);
    vec3 n = vec3(o, 1 - abs(o.x) - abs(o.y));
    float fold = max(-n.z, 0);
    n.x += n.x >= 0 ? -fold : fold;
    n.y += n.y >= 0 ? -fold : fold;
    return n;
}

vec3 octahedral_decode(uint u)
{
    vec3 n = octahedral_unfold(u);
    return n * inversesqrt(dot(n, n));
}

uint octahedral_encode(vec3 n)
{
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 o = n.xy;
    if (n.z < 0)
        o = (1 - abs(n.yx)) * vec2(n.x >= 0 ? 1 : -1, n.y >= 0 ? 1 : -1);
    return packSnorm2x16(o);
}

// Of the sample's cell: every pixel's owner of a point is the one whose sample is nearest, as far as
// that is the same offset in every pixel.
PRECISE vec2 sample_shift()
{
    vec2 cell = vec2(push_sample % SAMPLE_GRID, push_sample / SAMPLE_GRID);
    return (cell + 0.5) / float(SAMPLE_GRID) - 0.5;
}

// What places points, loaded once a thread: within a loop a CPU device would load it for each point.
struct PointView {
    REAL3 x, y, z, shift; // rows from a position to pixels times depth, and depth; orthographic: pixels
    REAL3 eye;            // orthographic: the direction of sight
};
PointView point_view;

void point_view_keep()
{
    const REAL r[9] = FRAME(rotation), t[3] = FRAME(translation);
    REAL2 focal = REAL2(FRAME(focal)[0], FRAME(focal)[1]), middle = REAL2(FRAME(center)[0], FRAME(center)[1]);
    REAL2 slant = ORTHOGRAPHIC ? REAL2(0) : middle;
    PRECISE PointView v;
    v.z = REAL3(r[6], r[7], r[8]);
    v.x = focal.x * REAL3(r[0], r[1], r[2]) + slant.x * v.z;
    v.y = focal.y * REAL3(r[3], r[4], r[5]) + slant.y * v.z;
    v.shift = REAL3(focal * REAL2(t[0], t[1]) + middle * (ORTHOGRAPHIC ? 1 : t[2]), t[2]);
    v.eye = REAL3(FRAME(eye)[0], FRAME(eye)[1], FRAME(eye)[2]);
    point_view = v;
}

// Depth of a point's centre, and its place in the picture. Only products and sums are done in double;
// the quotient is float, with its remainder beside it.
float point_place(vec3 a, out Place place)
{
    PointView v = point_view;
    PRECISE REAL3 c = REAL3(v.x.x * a.x + v.x.y * a.y + v.x.z * a.z + v.shift.x,
                            v.y.x * a.x + v.y.y * a.y + v.y.z * a.z + v.shift.y,
                            v.z.x * a.x + v.z.y * a.y + v.z.z * a.z + v.shift.z);
    float depth = float(c.z), over = ORTHOGRAPHIC ? 1 : depth;
    // A point far outside the picture keeps its place within what an int holds.
    PRECISE vec2 whole = floor(clamp(vec2(c.xy) / over, vec2(-1e8), vec2(1e8)));
    PRECISE vec2 part = vec2(c.xy - REAL2(whole) * (ORTHOGRAPHIC ? 1 : c.z)) / over;
    place = Place(ivec2(whole), part);
    return depth;
}

// A point's normal, of any length; away: above 0 where it is seen from behind. One that is not known
// faces the eye.
vec3 point_normal(uvec4 t, out float away)
{
    PRECISE vec3 sight = vec3(ORTHOGRAPHIC ? point_view.eye : REAL3(uintBitsToFloat(t.xyz)) - point_view.eye);
    vec3 n = octahedral_unfold(t.w);
    if (HAS_UNKNOWN && t.w == STP_NO_NORMAL)
        n = -sight;
    PRECISE float along = inner(n, sight);
    away = along;
    return n;
}

// False: culled, or outside near and far.
bool point_seen(uvec4 t, float depth)
{
    float away = -1;
    if (CULL_BACK)
        point_normal(t, away);
    return away < 0 && depth >= frame.near_depth && depth <= frame.far_depth;
}

// The pixel that the point falls into, from the grid's first, and where in it: -0.5 to 0.5.
// False: outside the grid.
bool point_pixel(Place place, out uvec2 pixel, out vec2 offset)
{
    vec2 part = place.part - sample_shift(), whole = floor(part);
    ivec2 at = place.whole + ivec2(whole) - ivec2(frame.grid_x, frame.grid_y);
    offset = part - whole - 0.5;
    pixel = uvec2(at);
    return all(lessThan(pixel, uvec2(frame.grid_width, frame.grid_height)));
}

// Keys of pixels lie in blocks of 8 x 8.
uint grid_index(uvec2 p)
{
    uvec2 b = p / STP_BLOCK, i = p % STP_BLOCK;
    return (b.y * (frame.grid_width / STP_BLOCK) + b.x) * (STP_BLOCK * STP_BLOCK) +
           i.y * STP_BLOCK + i.x;
}

// Of an open pixel: the word that holds its limit.
uint limit_place(uvec2 p)
{
    return frame.grid_width * frame.grid_height + grid_index(p);
}

// A pixel that any disc may reach yet: it takes the nearest of those that are before `limit` by their
// radius; infinite: of all.
void open_pixel(uvec2 p, float limit)
{
    frame.keys.v[grid_index(p)] = packUint2x32(uvec2(STP_RIM_NONE, STP_RIM_DEPTH));
    frame.rim.v[limit_place(p)] = floatBitsToUint(limit);
}

float open_limit(uvec2 p)
{
    return uintBitsToFloat(frame.rim.v[limit_place(p)]);
}

uint block_count()
{
    return frame.grid_width / STP_BLOCK * (frame.grid_height / STP_BLOCK);
}

// The word of the open pixels in half a block: its rows 0 to 3, or 4 to 7.
uint open_word(uint block, uint half_)
{
    return STP_WORK_FLAGS + block_count() + 2 * block + half_;
}

// Arguments of an indirect dispatch grow to so many workgroups.
void count_groups(uint argument, uint groups)
{
    atomicMax(frame.work.v[argument], min(groups, STP_ROW));
    atomicMax(frame.work.v[argument + 1], (groups + STP_ROW - 1) / STP_ROW);
}

// Lists of blocks: those that can hold something (pyramid_blocks.comp), those with pixels to be looked
// at again, those with open pixels.
const uint TOUCHED = 0, LOOK = 1, OPEN = 2;

uint list_place(uint list, uint index)
{
    return STP_WORK_FLAGS + (STP_WORK_BLOCK_RESET + list) * block_count() + index;
}

uint listed_block(uint list, uint index)
{
    return frame.work.v[list_place(list, index)];
}

// Puts a block on a list, once.
void list_block(uint list, uint argument, uint flag, uint block)
{
    if ((atomicOr(frame.work.v[STP_WORK_FLAGS + block], flag) & flag) != 0)
        return;
    uint slot = atomicAdd(frame.work.v[argument + 3], 1);
    frame.work.v[list_place(list, slot)] = block;
    count_groups(argument, slot + 1);
}

// The open pixels that a thread found in its block.
void list_open(uint block, uvec2 bits)
{
    if ((bits.x | bits.y) == 0)
        return;
    atomicOr(frame.work.v[open_word(block, 0)], bits.x);
    atomicOr(frame.work.v[open_word(block, 1)], bits.y);
    list_block(OPEN, STP_WORK_OPEN, STP_BLOCK_OPEN, block);
}

uvec2 open_bit(uint i)
{
    return uvec2(i < 32 ? 1u << i : 0, i < 32 ? 0 : 1u << (i - 32));
}
#endif
