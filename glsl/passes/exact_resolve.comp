#version 460
#extension GL_GOOGLE_include_directive : require
// The fragments of a pixel, resolved exactly: ZP Eq. 1 in integers, so that the order in which the
// fragments came does not matter. Overflowed pixels are made ready for the repair passes.
#include "lib/common.glsl"
#include "lib/splat.glsl"
#include "lib/key.glsl"
#include "lib/resolve.glsl"
#include "lib/shade.glsl"

const float WEIGHT_UNIT = 4095.0, PART_UNIT = 8192.0; // 12 + 13 bits, 32 fragments: below 2^31

struct Sums {
    int weight, depth;
    ivec3 normal;
    i64vec3 albedo;
};

void sums_add(inout Sums s, float w, vec3 normal, float above, uint id)
{
    float q = round(w * WEIGHT_UNIT), part = q * PART_UNIT;
    s.weight += int(q);
    s.normal += ivec3(round(normal * part));
    s.depth += int(round(above * part));
    if (HAS_COLOR)
        s.albedo += i64vec3(round(frame.colors.v[id] * (q * frame.color_scale)));
}

void overflowed(uint pixel)
{
    atomicAdd(frame.work.v[STP_WORK_OVERFLOW], 1);
    uint groups = (frame.splat_count + STP_GROUP - 1) / STP_GROUP;
    atomicMax(frame.work.v[STP_WORK_REPAIR], min(groups, STP_ROW));
    atomicMax(frame.work.v[STP_WORK_REPAIR + 1], (groups + STP_ROW - 1) / STP_ROW);
    atomicMax(frame.work.v[STP_WORK_REPAIR_L], frame.work.v[STP_WORK_LARGE]);
    atomicMax(frame.work.v[STP_WORK_REPAIR_L + 1], frame.work.v[STP_WORK_LARGE + 1]);
    atomicMax(frame.work.v[STP_WORK_REPAIR_BLOCKS], gl_NumWorkGroups.x);
    atomicMax(frame.work.v[STP_WORK_REPAIR_BLOCKS + 1], gl_NumWorkGroups.y);
    for (uint i = 0; i < STP_SUM_WORDS; i++)
        frame.keys.v[pixel * STP_SLOTS + i] = i == 0 ? ~0ul : 0ul;
}

float slot_depth(uint64_t key, out float rho2, out uint normal)
{
    uint depth;
    if (!PACKED)
        return uintBitsToFloat(uint(key >> 32));
    key_unpack(key, depth, rho2, normal);
    return float(depth);
}

uint slot_id(uint at, uint64_t key)
{
    return PACKED ? (KEY_IDS ? frame.key_ids.v[at] : STP_NO_ID) : uint(key);
}

void main()
{
    uvec2 p;
    uint pixel;
    if (!resolve_pixel(p, pixel))
        return;
    uint count = frame.counts.v[pixel], base = pixel * STP_SLOTS;
    if (count > STP_SLOTS) {
        overflowed(pixel);
        return;
    }
    float near = 1.0 / 0.0, rho2;
    uint normal = 0, near_packed = 0;
    uint64_t best = ~0ul;
    for (uint i = 0; i < count; i++) {
        uint64_t key = frame.keys.v[base + i];
        float depth = slot_depth(key, rho2, normal);
        // With ids beside packed keys, equal depths go to the lower id, as everywhere.
        uint64_t rank = KEY_IDS ? uint64_t(depth) << 32 | slot_id(base + i, key) : key;
        if (rank < best) {
            best = rank;
            near = depth;
            near_packed = normal;
        }
    }
    bool hit = count > 0;
    Surface s;
    s.id = PACKED && !KEY_IDS ? STP_NO_ID : uint(best);
    float unit = PACKED ? frame.depth_scale : 1.0;
    float epsilon = hit ? object_epsilon(s.id) * unit : 0, inv_epsilon = 1 / epsilon;
    Sums sums = Sums(0, 0, ivec3(0), i64vec3(0));
    s.fragments = 0;
    for (uint i = 0; i < count; i++) {
        uint64_t key = frame.keys.v[base + i];
        float depth = slot_depth(key, rho2, normal);
        if (depth > near + epsilon)
            continue;
        uint id = slot_id(base + i, key);
        vec3 n;
        if (PACKED) {
            n = normal_decode(normal);
        } else {
            Splat splat;
            rho2 = fragment_again(id, p, splat).rho2;
            n = splat.normal;
        }
        sums_add(sums, kernel_weight(rho2), n, (depth - near) * inv_epsilon, id);
        s.fragments++;
    }
    float weight = float(sums.weight);
    s.weight = weight / WEIGHT_UNIT;
    s.normal = vec3(sums.normal) / (WEIGHT_UNIT * PART_UNIT);
    s.near_depth = PACKED ? depth_restore(uint(near)) : near;
    s.depth = s.near_depth + float(sums.depth) / (weight * PART_UNIT) * (epsilon / unit);
    s.albedo = vec3(sums.albedo) / (WEIGHT_UNIT * frame.color_scale);
    s.near_normal = PACKED ? normal_decode(near_packed) : vec3(0, 0, -1);
    if (!PACKED && hit) {
        Splat splat;
        splat_load(s.id, splat);
        s.near_normal = splat.normal;
    }
    surface_write(p, hit, s);
}
