// The slots and lists of exact's pixels, and what their sums are a surface of. Needs resolve.glsl and
// shade.glsl.
#include "lib/terms.glsl"

// FETCHED: slots are read as texels, which a software device gathers at once where loads through an
// address take a turn a lane.
#ifdef FETCHED
layout(set = 0, binding = STP_BINDING_SLOTS) uniform utextureBuffer slot_texels;
layout(set = 0, binding = STP_BINDING_SLOT_IDS) uniform utextureBuffer slot_id_texels;
layout(set = 0, binding = STP_BINDING_TRAITS) uniform utextureBuffer traits_texels;

Traits traits_read(uint id)
{
    uvec2 words = texelFetch(traits_texels, int(id)).xy;
    return Traits(words.x, words.y);
}
#endif

// home: the pixel; of a list its first slot.
uint slot_at(uint home, uint i)
{
#ifdef LISTS
    return home + i;
#else
    return slot_index(home, i);
#endif
}

Slot slot_read(uint home, uint i, bool present)
{
    Slot slot = SLOT_NONE;
    uint at = slot_at(home, i);
#ifdef FETCHED
    slot.key = texelFetch(slot_texels, int(at)).xy;
    if (SLOT_IDS)
        slot.id = texelFetch(slot_id_texels, int(at)).x;
#else
    if (present) {
        slot.key = unpackUint2x32(frame.keys.v[at]);
        if (SLOT_IDS)
            slot.id = frame.key_ids.v[at];
    }
#endif
    return slot;
}

Traits slot_traits(Slot slot, Rank rank, bool present)
{
    if (TRAITS)
        return traits_read(present ? rank_id(rank) : 0);
    return Traits(slot.key.x & STP_NORMAL_MASK, 0);
}

Term slot_term(Slot slot, bool present, uvec2 p)
{
    Rank rank = slot_rank(slot, present);
    float rho2 = key_rho2(slot.key);
    Traits traits = slot_traits(slot, rank, present);
    vec3 n = normal_decode(traits.normal & STP_NORMAL_MASK);
    if (!PACKED && present) {
        Splat splat;
        Fragment f = fragment_again(rank_id(rank), p, splat);
        rho2 = f.rho2;
        n = fragment_normal(splat, f);
        traits.normal = normal_encode(n);
    }
    return term_make(rank, present, rho2, n, traits);
}

// Of a sum in two parts that may overlap: the lower has that many bits.
vec4 sums_join(Sums sums, int bits)
{
    SUM4 high = sums.high + (sums.low >> bits), low = sums.low & SUM4((1 << bits) - 1);
    return vec4(high) * float(1 << bits) + vec4(low);
}

vec3 sums_color(Sums sums)
{
    return sums_join(sums, COLOR_PART_BITS).rgb / (COLOR_CODES ? UNIT * STP_COLOR_STEPS : frame.color_scale);
}

// The packed normal of the nearest.
uint sums_near_encoded(Sums sums, Rank near)
{
    if (TRAITS)
        return traits_read(min(rank_id(near), frame.splat_count - 1)).normal & STP_NORMAL_MASK;
    return PACKED && !KEY_IDS ? near.low & STP_NORMAL_MASK : sums.near_encoded;
}

// Their opacity; where the weights vanish, that of the nearest.
float sums_alpha(Sums sums, uint near_id)
{
    if (sums.weight == 0)
        return splat_opacity(near_id);
    return sums_join(sums, STP_PART_BITS).a / (float(sums.weight) * (ALPHA_UNIT / UNIT));
}

// epsilon: in the units of depths.
Surface sums_surface(Sums sums, Rank near, float epsilon)
{
    Surface s;
    float weight = float(sums.weight);
    s.id = rank_id(near);
    s.fragments = sums.fragments;
    s.weight = weight / UNIT;
    s.normal = vec3(sums.normal) / UNIT;
    s.near_normal = normal_decode(sums_near_encoded(sums, near));
    s.near_depth = PACKED ? depth_restore(uint(near.depth)) : near.depth;
    float unit = PACKED ? frame.depth_scale : 1.0;
    s.depth = s.near_depth + float(sums.depth) / weight * (epsilon / unit);
    s.albedo = sums_color(sums);
    return s;
}

// The pixel has more fragments than slots: exact_arm then sends the repair passes, and
// exact_collect looks for its block.
bool slots_overflowed(uint pixel, uint count)
{
    if (count <= STP_SLOTS)
        return false;
    frame.work.v[STP_WORK_OVERFLOW] = 1;
    frame.work.v[STP_WORK_FLAGS + pixel / STP_GROUP] = STP_BLOCK_OVERFLOWED;
    return true;
}
