#ifndef POINTS_GLSL
#define POINTS_GLSL
// Points of 16 bytes (MKC 3.1): position relative to the origin, octahedral normal. Fetched as texels,
// which a CPU device loads by the vector, eight points at once, where addresses go one by one.
layout(set = 0, binding = STP_BINDING_POINTS) uniform usamplerBuffer point_texels;

vec3 octahedral_decode(uint u)
{
    vec2 o = unpackSnorm2x16(u);
    vec3 n = vec3(o, 1 - abs(o.x) - abs(o.y));
    float fold = max(-n.z, 0);
    n.x += n.x >= 0 ? -fold : fold;
    n.y += n.y >= 0 ? -fold : fold;
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
vec2 sample_shift()
{
    vec2 cell = vec2(push_sample % SAMPLE_GRID, push_sample / SAMPLE_GRID);
    return (cell + 0.5) / float(SAMPLE_GRID) - 0.5;
}

// A point in the camera frame, without its radius. False: culled, or outside near and far.
bool point_load(uint index, out Splat s)
{
    uvec4 t = texelFetch(point_texels, int(index));
    const float r[9] = frame.rotation;
    splat_place(uintBitsToFloat(t.xyz), s);
    vec3 b = octahedral_decode(t.w);
    s.normal = vec3(r[0] * b.x + r[1] * b.y + r[2] * b.z, r[3] * b.x + r[4] * b.y + r[5] * b.z,
                    r[6] * b.x + r[7] * b.y + r[8] * b.z);
    if (HAS_UNKNOWN && t.w == STP_NO_NORMAL)
        s.normal = ORTHOGRAPHIC ? vec3(0, 0, -1) : -normalize(s.center);
    float away = ORTHOGRAPHIC ? s.normal.z : dot(s.normal, s.center);
    if (TWO_SIDED && away > 0)
        s.normal = -s.normal;
    return (!CULL_BACK || away < 0) && s.center.z >= frame.near_depth &&
           s.center.z <= frame.far_depth;
}

// The pixel that the point falls into, from the grid's first, and where in it: -0.5 to 0.5.
// False: outside the grid.
bool point_pixel(Splat s, out uvec2 pixel, out vec2 offset)
{
    vec2 part = s.place.part - sample_shift(), whole = floor(part);
    ivec2 at = s.place.whole + ivec2(whole) - ivec2(frame.grid_x, frame.grid_y);
    offset = part - whole - 0.5;
    pixel = uvec2(at);
    return all(greaterThanEqual(at, ivec2(0))) &&
           all(lessThan(at, ivec2(frame.grid_width, frame.grid_height)));
}

// Keys of pixels lie in blocks of 8 x 8.
uint grid_index(uvec2 p)
{
    uvec2 b = p / STP_BLOCK, i = p % STP_BLOCK;
    return (b.y * (frame.grid_width / STP_BLOCK) + b.x) * (STP_BLOCK * STP_BLOCK) +
           i.y * STP_BLOCK + i.x;
}

// A pixel that discs from afar may reach yet: it takes the nearest that is before `depth`, an order of
// depth_order's; STP_RIM_DEPTH: any.
void open_pixel(uvec2 p, uint depth)
{
    frame.keys.v[grid_index(p)] = packUint2x32(uvec2(STP_RIM_NONE, depth));
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
