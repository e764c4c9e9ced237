#version 460
#extension GL_GOOGLE_include_directive : require
// Mending, a turn's end: the summed layer joins its ray, and the next one is put at hand; a ray
// without one is written. CLEAR and FIRST come before the first turn: they empty the state, and put
// the first layer at hand.
#include "lib/common.glsl"
#define WIDE
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/resolve.glsl"
#include "lib/shade.glsl"
#include "lib/slots.glsl"
#define MENDED_RAYS
#include "lib/layers.glsl"
#include "lib/mend.glsl"

uint64_t word(uint pixel, uint at)
{
    return frame.keys.v[mend_at(pixel, at)];
}

int64_t sum(uint pixel, uint at)
{
    return int64_t(word(pixel, MEND_SUMS + at));
}

void clear_sums(uint pixel)
{
    for (uint i = 0; i < MEND_SUM_WORDS; i++)
        frame.keys.v[mend_at(pixel, MEND_SUMS + i)] = 0;
}

// Two floats a word.
void put(uint pixel, uint at, float a, float b)
{
    frame.keys.v[mend_at(pixel, MEND_RAY + at)] =
        packUint2x32(uvec2(floatBitsToUint(a), floatBitsToUint(b)));
}

vec2 get(uint pixel, uint at)
{
    return uintBitsToFloat(unpackUint2x32(word(pixel, MEND_RAY + at)));
}

void ray_store(uint pixel, Ray r)
{
    put(pixel, 0, r.color.x, r.color.y);
    put(pixel, 1, r.color.z, r.through);
    put(pixel, 2, uintBitsToFloat(r.layers), r.first.depth);
    put(pixel, 3, r.first.normal.x, r.first.normal.y);
    put(pixel, 4, r.first.normal.z, r.surface.weight);
    put(pixel, 5, r.first.albedo.x, r.first.albedo.y);
    put(pixel, 6, r.first.albedo.z, uintBitsToFloat(r.surface.id));
    put(pixel, 7, uintBitsToFloat(r.surface.fragments), r.alpha);
    if ((OPTICS & STP_OPTICS_ABSORBS) != 0) {
        put(pixel, 8, r.tint.x, r.tint.y);
        put(pixel, 9, r.tint.z, 0);
    }
}

Ray ray_restore(uint pixel)
{
    Ray r = RAY_START;
    vec2 a = get(pixel, 0), b = get(pixel, 1), c = get(pixel, 2), d = get(pixel, 3);
    vec2 e = get(pixel, 4), f = get(pixel, 5), g = get(pixel, 6), h = get(pixel, 7);
    r.color = vec3(a, b.x);
    r.through = b.y;
    r.layers = floatBitsToUint(c.x);
    r.first.depth = c.y;
    r.first.normal = vec3(d, e.x);
    r.surface.weight = e.y;
    r.first.albedo = vec3(f, g.x);
    r.surface.id = floatBitsToUint(g.y);
    r.surface.fragments = floatBitsToUint(h.x);
    r.alpha = h.y;
    if ((OPTICS & STP_OPTICS_ABSORBS) != 0)
        r.tint = vec3(get(pixel, 8), get(pixel, 9).x);
    return r;
}

Sums sums_restore(uint pixel)
{
    Sums s = SUMS_NONE;
    s.weight = sum(pixel, 0);
    s.depth = sum(pixel, 1);
    s.normal = i64vec3(sum(pixel, 2), sum(pixel, 3), sum(pixel, 4));
    // All of it in the lower part.
    s.low = i64vec4(sum(pixel, 5), sum(pixel, 6), sum(pixel, 7), sum(pixel, 8));
    s.fragments = uint(sum(pixel, 9));
    s.near_encoded = uint(word(pixel, MEND_NEAR));
    return s;
}

// The nearer of what is left comes next. False: nothing is left.
bool advance(uint pixel)
{
    uint64_t next = word(pixel, MEND_NEXT), wall = word(pixel, MEND_WALL);
    uint64_t now = uint(next >> 32) < uint(wall >> 32) ? next : wall;
    frame.keys.v[mend_at(pixel, MEND_NOW)] = now;
    frame.keys.v[mend_at(pixel, MEND_NEXT)] = STP_SUMS_NONE;
    clear_sums(pixel);
    if (now != STP_SUMS_NONE)
        frame.work.v[STP_WORK_REMAINING] = 1;
    return now != STP_SUMS_NONE;
}

#ifdef CLEAR
// Places within a block go to whichever pixel asks first: its list's sums are the same anywhere.
uint list_place(uint pixel)
{
    uint word = list_block(pixel / STP_GROUP);
    if (ATOMIC_LOAD(frame.work.v[word]) == STP_LIST_NONE) // other threads add to it meanwhile
        return STP_LIST_NONE;
    return atomicAdd(frame.work.v[word], frame.counts.v[pixel]);
}

void turn(uint pixel, uvec2 p)
{
    frame.keys.v[list_word(pixel)] = packUint2x32(uvec2(0, list_place(pixel)));
    for (uint i = MEND_NOW; i <= MEND_WALL; i++)
        frame.keys.v[mend_at(pixel, i)] = STP_SUMS_NONE;
    ray_store(pixel, RAY_START);
}
#elif defined(FIRST)
void turn(uint pixel, uvec2 p)
{
    advance(pixel);
}
#else
void turn(uint pixel, uvec2 p)
{
    uint64_t now = word(pixel, MEND_NOW), wall = word(pixel, MEND_WALL);
    if (now == STP_SUMS_NONE)
        return;
    bool solid = MIXED && now == wall;
    Rank near = mend_rank(now);
    Sums sums = sums_restore(pixel);
    float alpha = OPACITY == 1 ? frame.opacity : sums_alpha(sums, rank_id(near));
    Ray ray = ray_restore(pixel);
    ray_layer(ray, p, sums_surface(sums, near, rank_epsilon(near)), solid ? 1 : alpha);
    if (solid)
        frame.keys.v[mend_at(pixel, MEND_WALL)] = STP_SUMS_NONE;
    ray_store(pixel, ray);
    // Of several samples only a finished ray may be added. A host's frame takes no more turns than
    // were recorded: what it has then is what stays.
    bool ended = !advance(pixel);
    if (ended || SAMPLE_GRID == 1)
        ray_write(ray, p);
    ray_deep(ray, p, ended);
}
#endif

void main()
{
    uvec2 p;
    uint pixel;
#ifdef CLEAR
    if (resolve_pixel(p, pixel) && deep(pixel))
#else
    if (resolve_pixel(p, pixel) && !mend_skip(pixel))
#endif
        turn(pixel, p);
}
