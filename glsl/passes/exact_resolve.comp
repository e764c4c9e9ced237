#version 460
#extension GL_GOOGLE_include_directive : require
// The fragments of a pixel, resolved exactly: ZP Eq. 1 in integers, so that the order in which the
// fragments came does not matter. Overflowed pixels are left to the repair passes.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/resolve.glsl"
#include "lib/shade.glsl"

const float UNIT = 16777216.0, COLOR_UNIT = 4096.0; // 64 fragments: below 2^31, and 2^63

struct Sums {
    int weight, depth;
    ivec3 normal;
    i64vec3 albedo;
};

void sums_add(inout Sums s, float w, vec3 normal, float above, uint id)
{
    float part = w * UNIT;
    s.weight += int(round(part));
    s.normal += ivec3(round(normal * part));
    s.depth += int(round(above * part));
    if (HAS_COLOR)
        s.albedo += i64vec3(round(frame.colors.v[id] * (w * COLOR_UNIT * frame.color_scale)));
}

// In quantised steps when packed.
float slot_depth(uvec2 key)
{
    return PACKED ? float(key_depth(key)) : depth_ordered(key.y);
}

uint slot_id(uint at, uvec2 key)
{
    return PACKED ? (KEY_IDS ? frame.key_ids.v[at] : STP_NO_ID) : key.x;
}

// The nearest fragment has the least rank: equal depths go to the lower id where there are ids.
uint64_t slot_rank(uint at, uint64_t key)
{
    if (KEY_IDS && key != ~0ul)
        return packUint2x32(uvec2(frame.key_ids.v[at], key_depth(unpackUint2x32(key))));
    return key;
}

void take(inout Sums sums, inout Surface s, bool present, uint at, uint64_t key64, float near,
          float epsilon, uvec2 p)
{
    uvec2 key = unpackUint2x32(key64);
    float depth = slot_depth(key), rho2 = key_rho2(key);
    bool counts = present && depth <= near + epsilon;
    uint id = slot_id(at, key);
    vec3 n = key_normal(key);
    if (!PACKED && counts) {
        Splat splat;
        rho2 = fragment_again(id, p, splat).rho2;
        n = splat.normal;
    }
    float w = counts ? kernel_weight(rho2) : 0;
    sums_add(sums, w, n, counts ? (depth - near) / epsilon : 0, counts ? id : 0);
    s.fragments += counts ? 1 : 0;
    if ((KEY_IDS || !PACKED) && counts && id == s.id)
        s.near_normal = n;
}

// The first slots are read once and kept in registers.
const uint KEPT = 8;

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    uint count = frame.counts.v[pixel];
    if (count > STP_SLOTS) {
        // exact_arm then sends the repair passes, and exact_collect looks for this block.
        frame.work.v[STP_WORK_OVERFLOW] = 1;
        frame.work.v[STP_WORK_FLAGS + pixel / STP_GROUP] = STP_BLOCK_OVERFLOWED;
        return;
    }
    uint64_t kept[KEPT], best = ~0ul;
    [[unroll]] for (uint i = 0; i < KEPT; i++) {
        kept[i] = i < count ? frame.keys.v[slot_index(pixel, i)] : ~0ul;
        best = min(best, slot_rank(slot_index(pixel, i), kept[i]));
    }
    for (uint i = KEPT; i < count; i++)
        best = min(best, slot_rank(slot_index(pixel, i), frame.keys.v[slot_index(pixel, i)]));
    bool hit = count > 0;
    Surface s;
    s.id = PACKED && !KEY_IDS ? STP_NO_ID : uint(best);
    float near = KEY_IDS ? float(uint(best >> 32)) : slot_depth(unpackUint2x32(best));
    float unit = PACKED ? frame.depth_scale : 1.0;
    float epsilon = hit ? object_epsilon(s.id) * unit : 0;
    Sums sums = Sums(0, 0, ivec3(0), i64vec3(0));
    s.fragments = 0;
    s.near_normal = PACKED && !KEY_IDS ? key_normal(unpackUint2x32(best)) : vec3(0, 0, -1);
    [[unroll]] for (uint i = 0; i < KEPT; i++)
        take(sums, s, i < count, slot_index(pixel, i), kept[i], near, epsilon, p);
    for (uint i = KEPT; i < count; i++)
        take(sums, s, true, slot_index(pixel, i), frame.keys.v[slot_index(pixel, i)], near, epsilon, p);
    float weight = float(sums.weight);
    s.weight = weight / UNIT;
    s.normal = vec3(sums.normal) / UNIT;
    s.near_depth = PACKED ? depth_restore(uint(near)) : near;
    s.depth = s.near_depth + float(sums.depth) / weight * (epsilon / unit);
    s.albedo = vec3(sums.albedo) / (COLOR_UNIT * frame.color_scale);
    surface_write(p, hit, s);
}
