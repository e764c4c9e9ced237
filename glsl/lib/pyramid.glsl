#ifndef PYRAMID_GLSL
#define PYRAMID_GLSL
// A texel of the pyramid (docs/pyramid.md, "The texel"): a disc, and how far the discs that it stands for
// reach in depth. ATTRIBUTES adds colours (1), or colours, ids and objects (2).
#include "lib/points.glsl"
layout(set = 0, binding = STP_BINDING_PYRAMID, rgba32ui) uniform uimage2DArray pyramid;
#if ATTRIBUTES == 1
layout(set = 0, binding = STP_BINDING_ATTRIBUTES, rg32ui) uniform uimage2DArray attributes;
#elif ATTRIBUTES == 2
layout(set = 0, binding = STP_BINDING_ATTRIBUTES, rgba32ui) uniform uimage2DArray attributes;
#endif

struct Texel {
    float depth;  // of the centre; infinite: nothing is here
    float extent; // the interval is [depth - extent, depth + extent + radius]
    float radius;
    vec3 normal; // camera frame
    vec2 center; // pixels
    bool full;   // the surface goes on all over the texel, as far as its points tell
    bool rim;    // pushed, and beside it nothing is: it may reach farther than the points' discs
    bool exact;  // the disc is one point's
    bool inside; // pushed, and one point's disc holds all of the texel
};

// Where sums begin.
const Texel EMPTY = Texel(0, 0, 0, vec3(0), vec2(0), false, false, false, false);

struct Attributes {
    vec3 color;
    uint id, object; // of the frontmost
};

const float NOTHING = 1.0 / 0.0;

bool texel_valid(Texel t)
{
    return t.depth < NOTHING;
}

ivec2 level_origin(uint level)
{
    return ivec2(frame.grid_x, frame.grid_y) >> int(level);
}

uvec2 level_size(uint level)
{
    ivec2 last = ivec2(frame.grid_x + int(frame.grid_width), frame.grid_y + int(frame.grid_height)) - 1;
    return uvec2((last >> int(level)) - level_origin(level) + 1);
}

// Level 0 fills the left of the image, the others stand above each other beside it.
ivec3 level_place(uint level, ivec2 p)
{
    return ivec3(p + (level == 0 ? ivec2(0) : ivec2(frame.level_column, frame.level_row[level])), 0);
}

// Of texel p, counted from the level's first, in pixels of the whole picture.
vec2 level_middle(uint level, ivec2 p)
{
    return (vec2(p + level_origin(level)) + 0.5) * float(1u << level);
}

// Above level 0 the last bits of the displacement say more.
const uint EXACT = 1u, INSIDE = 0x10000u;

Texel texel_unpack(uint level, uvec4 u, vec2 middle)
{
    Texel t;
    t.exact = level == 0 || (u.w & EXACT) != 0;
    t.inside = level != 0 && (u.w & INSIDE) != 0;
    u.w &= level == 0 ? ~0u : ~(EXACT | INSIDE);
    vec2 size = unpackHalf2x16(u.y) * frame.radius_unit;
    t.depth = uintBitsToFloat(u.x);
    t.extent = abs(size.x);
    t.rim = (u.y & 0x8000u) != 0; // the sign of the extent
    t.radius = abs(size.y);
    t.full = (u.y & 0x80000000u) != 0; // the sign of the radius
    t.normal = octahedral_decode(u.z);
    t.center = middle + unpackHalf2x16(u.w);
    return t;
}

uvec4 texel_pack(uint level, Texel t, vec2 middle)
{
    uint place = packHalf2x16(t.center - middle);
    if (level != 0)
        place = (place & ~(EXACT | INSIDE)) | (t.exact ? EXACT : 0) | (t.inside ? INSIDE : 0);
    uint size = packHalf2x16(vec2(t.extent, t.radius) * frame.radius_scale);
    size |= (t.full ? 0x80000000u : 0) | (t.rim ? 0x8000u : 0);
    return uvec4(floatBitsToUint(t.depth), size, octahedral_encode(t.normal), place);
}

// Texels beyond the level's edge are empty.
Texel texel_load(uint level, ivec2 p)
{
    ivec2 size = ivec2(level_size(level));
    bool inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size));
    uvec4 u = imageLoad(pyramid, level_place(level, clamp(p, ivec2(0), size - 1)));
    Texel t = texel_unpack(level, u, level_middle(level, p));
    t.depth = inside ? t.depth : NOTHING;
    return t;
}

void texel_store(uint level, ivec2 p, Texel t)
{
    imageStore(pyramid, level_place(level, p),
               texel_valid(t) ? texel_pack(level, t, level_middle(level, p))
                              : uvec4(floatBitsToUint(NOTHING), 0, 0, 0));
}

Attributes attributes_load(uint level, ivec2 p)
{
    Attributes a = Attributes(vec3(0), STP_NO_ID, 0);
#if ATTRIBUTES > 0
    uvec4 u = imageLoad(attributes, level_place(level, clamp(p, ivec2(0), ivec2(level_size(level)) - 1)));
    if (HAS_COLOR)
        a.color = vec3(unpackHalf2x16(u.x), unpackHalf2x16(u.y).x);
    a.id = u.z;
    a.object = u.w;
#endif
    return a;
}

void attributes_store(uint level, ivec2 p, Attributes a)
{
#if ATTRIBUTES > 0
    imageStore(attributes, level_place(level, p),
               uvec4(packHalf2x16(a.color.xy), packHalf2x16(vec2(a.color.z, 0)), a.id, a.object));
#endif
}

// The disc as the ray through pixel position q meets it, in perspective. A disc seen so flat that it
// would be thinner than the floor turns towards the eye until it is not. False: missed. away2: squared
// distance of the plane's hit from the centre, infinite without one; reach: the disc's radius.
bool disc_miss(Texel t, vec2 q, out float depth, out float away2, out float reach)
{
    vec2 inverse = vec2(frame.inv_focal[0], frame.inv_focal[1]);
    PRECISE vec2 d = (q - t.center) * inverse;
    PRECISE vec2 at = (t.center + sample_shift() - vec2(frame.center[0], frame.center[1])) * inverse;
    vec3 ray = ORTHOGRAPHIC ? vec3(0, 0, 1) : vec3(at, 1);
    float unit = ORTHOGRAPHIC ? 1 : t.depth;
    PRECISE float least = frame.pyramid_floor * min(inverse.x, inverse.y) * unit; // half the floor, scene units
    PRECISE float radius = max(t.radius, least), slope = least / radius;
    PRECISE vec3 view = ray * inversesqrt(inner(ray, ray)), n = t.normal;
    PRECISE float facing = inner(n, view);
    if (FLOOR && abs(facing) < slope) {
        PRECISE vec3 along = n - facing * view;
        float flat_ = facing < 0 ? -slope : slope;
        n = flat_ * view + along * (sqrt(1 - slope * slope) * inversesqrt(max(inner(along, along), 1e-20)));
    }
    PRECISE float g = inner(n, ray), rise = n.x * d.x + n.y * d.y, den = ORTHOGRAPHIC ? g : g + rise;
    PRECISE vec3 v = (g * vec3(d, 0) - ray * rise) * (unit / den);
    PRECISE float plane = t.depth - unit * rise / den;
    depth = plane;
    bool meets = den * g > 0;
    reach = radius;
    away2 = meets ? inner(v, v) : NOTHING;
    return meets && inner(v, v) <= radius * radius;
}

bool disc_hit(Texel t, vec2 q, out float depth)
{
    float away2, reach;
    return disc_miss(t, q, depth, away2, reach);
}
#endif
