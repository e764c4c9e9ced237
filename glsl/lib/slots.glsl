// The fragments that exact kept of a pixel, and sums of them in integers, so that the order in which
// they came does not matter. Needs key.glsl and resolve.glsl.

const float UNIT = 16777216.0, COLOR_UNIT = 4096.0; // 64 fragments: below 2^31, and 2^63
const float ALPHA_UNIT = 1099511627776.0; // 2^40: an opacity of 1e-6 keeps its own

// Of a slot's id word: the splat is opaque, where not all are.
const uint SLOT_OPAQUE = 0x80000000u;

struct Slot {
    uint64_t key;
    uint id; // with SLOT_OPAQUE; KEY_IDS only
};

// What a fragment adds to sums: the same for every layer that might take it.
struct Term {
    uint64_t rank;
    float depth;   // in the units of slot_depth
    uint word;     // slot_word
    uint encoded;  // the normal, in 28 bits
    int weight;    // in UNITs, as the rest, which is multiplied with it
    ivec3 normal;
    i64vec3 albedo; // in COLOR_UNITs
    int64_t alpha;  // in ALPHA_UNITs
};

struct Sums {
    int weight, depth;
    ivec3 normal;
    i64vec3 albedo;
    int64_t alpha;
    uint fragments;
    uint near_encoded; // the normal of the nearest
};

const Slot SLOT_NONE = Slot(~0ul, ~0u);
const Sums SUMS_NONE = Sums(0, 0, ivec3(0), i64vec3(0), 0l, 0, 0);

Slot slot_read(uint pixel, uint i, bool present)
{
    Slot slot = SLOT_NONE;
    if (present) {
        uint at = slot_index(pixel, i);
        slot.key = frame.keys.v[at];
        if (KEY_IDS)
            slot.id = frame.key_ids.v[at];
    }
    return slot;
}

// The word that holds the id, and whether the splat is opaque.
uint slot_word(Slot slot)
{
    return PACKED ? slot.id : uint(slot.key);
}

uint slot_id(uint word)
{
    if (PACKED && !KEY_IDS)
        return STP_NO_ID;
    return MIXED ? word & ~SLOT_OPAQUE : word;
}

bool word_opaque(uint word)
{
    return MIXED && (word & SLOT_OPAQUE) != 0;
}

// In quantised steps when packed.
float slot_depth(uvec2 key)
{
    return PACKED ? float(key_depth(key)) : depth_ordered(key.y);
}

// The nearest fragment has the least rank: equal depths go to the lower id where there are ids.
uint64_t slot_rank(Slot slot)
{
    if (KEY_IDS && slot.key != ~0ul)
        return packUint2x32(uvec2(slot.id, key_depth(unpackUint2x32(slot.key))));
    return slot.key;
}

float rank_depth(uint64_t rank)
{
    return KEY_IDS ? float(uint(rank >> 32)) : slot_depth(unpackUint2x32(rank));
}

// present: false for a slot that holds nothing.
Term slot_term(Slot slot, bool present, uvec2 p)
{
    Term t;
    uvec2 key = unpackUint2x32(slot.key);
    float rho2 = key_rho2(key);
    vec3 n = key_normal(key);
    t.rank = slot_rank(slot);
    t.depth = slot_depth(key);
    t.word = slot_word(slot);
    t.encoded = key.x & 0xfffffff;
    uint id = slot_id(t.word), known = present ? id : 0;
    if (!PACKED && present) {
        Splat splat;
        Fragment f = fragment_again(id, p, splat);
        rho2 = f.rho2;
        n = fragment_normal(splat, f);
        t.encoded = normal_encode(n);
    }
    float w = kernel_weight(rho2);
    t.weight = int(round(w * UNIT));
    t.normal = ivec3(round(n * (w * UNIT)));
    t.albedo = i64vec3(0);
    t.alpha = 0;
    if (HAS_COLOR)
        t.albedo = i64vec3(round(frame.colors.v[known] * (w * COLOR_UNIT * frame.color_scale)));
    if (OPACITY == 2)
        t.alpha = int64_t(round(splat_opacity(known) * (w * ALPHA_UNIT)));
    return t;
}

// Adds the term where it counts. near and epsilon are in the units of slot_depth.
void sums_take(inout Sums s, bool counts, Term t, float near, float epsilon, uint near_id)
{
    s.weight += counts ? t.weight : 0;
    s.normal += counts ? t.normal : ivec3(0);
    s.depth += counts ? int(round((t.depth - near) / epsilon * float(t.weight))) : 0;
    if (HAS_COLOR)
        s.albedo += counts ? t.albedo : i64vec3(0);
    if (OPACITY == 2)
        s.alpha += counts ? t.alpha : 0l;
    s.fragments += counts ? 1 : 0;
    if ((KEY_IDS || !PACKED) && counts && slot_id(t.word) == near_id)
        s.near_encoded = t.encoded;
}

// Their opacity; where the weights vanish, that of the nearest.
float sums_alpha(Sums sums, uint near_id)
{
    if (sums.weight == 0)
        return splat_opacity(near_id);
    return float(sums.alpha) / (float(sums.weight) * (ALPHA_UNIT / UNIT));
}

// best: the rank of the nearest; epsilon in the units of slot_depth.
Surface sums_surface(Sums sums, uint64_t best, float epsilon)
{
    Surface s;
    float weight = float(sums.weight), near = rank_depth(best);
    s.id = slot_id(uint(best));
    s.fragments = sums.fragments;
    s.weight = weight / UNIT;
    s.normal = vec3(sums.normal) / UNIT;
    s.near_normal = normal_decode(PACKED && !KEY_IDS ? uint(best) & 0xfffffff : sums.near_encoded);
    s.near_depth = PACKED ? depth_restore(uint(near)) : near;
    float unit = PACKED ? frame.depth_scale : 1.0;
    s.depth = s.near_depth + float(sums.depth) / weight * (epsilon / unit);
    s.albedo = vec3(sums.albedo) / (COLOR_UNIT * frame.color_scale);
    return s;
}

// In the units of slot_depth.
float slots_epsilon(uint64_t best)
{
    return object_epsilon(slot_id(uint(best))) * (PACKED ? frame.depth_scale : 1.0);
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
