// The fragments that exact kept of a pixel, and sums of them in integers, so that the order in which
// they came does not matter. Needs key.glsl and resolve.glsl.

// LISTS: of pixels that have more fragments than slots, which would overflow 32-bit sums.
#ifdef LISTS
#define SUM  int64_t
#define SUM3 i64vec3
#define SUM4 i64vec4
#else
#define SUM  int
#define SUM3 ivec3
#define SUM4 ivec4
#endif
const float UNIT = 16777216.0; // 64 fragments: below 2^31
// Colour and opacity are finer, 2^40: an opacity of 1e-6 keeps its own. They come in two parts that
// each fit a word, since a software device converts and adds words eight at a time.
const float ALPHA_UNIT = 1099511627776.0, PART = 1048576.0;

// Of a slot's id word: the splat is opaque, where not all are.
const uint SLOT_OPAQUE = 0x80000000u;

const float NEVER = 1.0 / 0.0;

// FETCHED: slots are read as texels, which a software device gathers at once where loads through an
// address take a turn a lane.
#ifdef FETCHED
layout(set = 0, binding = STP_BINDING_SLOTS) uniform utextureBuffer slot_texels;
layout(set = 0, binding = STP_BINDING_SLOT_IDS) uniform utextureBuffer slot_id_texels;
#endif

struct Slot {
    uvec2 key;
    uint id; // with SLOT_OPAQUE; KEY_IDS only
};

// The nearest fragment has the least rank: equal depths go to the lower id where there are ids.
struct Rank {
    float depth; // in quantised steps when packed; NEVER: there is no fragment
    uint low;    // slot_word; the key's lower word where there are no ids
};

// What a fragment adds to sums: the same for every layer that might take it.
struct Term {
    Rank rank;
    uint encoded; // the normal, in 28 bits
    int weight;   // in UNITs, as the rest, which is multiplied with it
    ivec3 normal;
    ivec4 high, low; // colour in units of color_scale, opacity in ALPHA_UNITs; high: PARTs of them
};

struct Sums {
    SUM weight, depth;
    SUM3 normal;
    SUM4 high, low;
    uint fragments;
    uint near_encoded; // the normal of the nearest
};

const Slot SLOT_NONE = Slot(uvec2(~0u), ~0u);
const Rank RANK_NONE = Rank(NEVER, ~0u);
const Term TERM_NONE = Term(RANK_NONE, 0, 0, ivec3(0), ivec4(0), ivec4(0));
const Sums SUMS_NONE = Sums(SUM(0), SUM(0), SUM3(0), SUM4(0), SUM4(0), 0, 0);

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
    if (KEY_IDS)
        slot.id = texelFetch(slot_id_texels, int(at)).x;
#else
    if (present) {
        slot.key = unpackUint2x32(frame.keys.v[at]);
        if (KEY_IDS)
            slot.id = frame.key_ids.v[at];
    }
#endif
    return slot;
}

// The word that holds the id, and whether the splat is opaque.
uint slot_word(Slot slot)
{
    return KEY_IDS ? slot.id : slot.key.x;
}

uint rank_id(Rank rank)
{
    if (PACKED && !KEY_IDS)
        return STP_NO_ID;
    return MIXED ? rank.low & ~SLOT_OPAQUE : rank.low;
}

bool rank_opaque(Rank rank)
{
    return MIXED && (rank.low & SLOT_OPAQUE) != 0;
}

// present: false for a slot that holds nothing.
Rank slot_rank(Slot slot, bool present)
{
    float depth = PACKED ? float(key_depth(slot.key)) : depth_ordered(slot.key.y);
    return Rank(present ? depth : NEVER, slot_word(slot));
}

void rank_min(inout Rank least, Rank rank)
{
    float depth = min(least.depth, rank.depth);
    uint low = least.depth == depth ? least.low : ~0u, other = rank.depth == depth ? rank.low : ~0u;
    least = Rank(depth, min(low, other));
}

Term slot_term(Slot slot, bool present, uvec2 p)
{
    Term t;
    float rho2 = key_rho2(slot.key);
    vec3 n = key_normal(slot.key);
    t.rank = slot_rank(slot, present);
    t.encoded = slot.key.x & 0xfffffff;
    uint id = rank_id(t.rank), known = present ? id : 0;
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
    vec4 fine = vec4(0);
    if (HAS_COLOR)
        fine.rgb = frame.colors.v[known] * (w * frame.color_scale);
    if (OPACITY == 2)
        fine.a = splat_opacity(known) * (w * ALPHA_UNIT);
    fine = round(fine);
    vec4 high = floor(fine / PART);
    t.high = ivec4(high);
    t.low = ivec4(fine - high * PART);
    return t;
}

// Adds the term where it counts. near: the nearest of those that do; part: 1 over its epsilon.
void sums_take(inout Sums s, bool counts, Term t, Rank near, float part)
{
    int depth = int(round((t.rank.depth - near.depth) * part * float(t.weight)));
    int kept = counts ? -1 : 0; // selections would become branches
    s.weight += t.weight & kept;
    s.normal += t.normal & ivec3(kept);
    s.depth += depth & kept;
    if (HAS_COLOR) {
        s.high.rgb += t.high.rgb & ivec3(kept);
        s.low.rgb += t.low.rgb & ivec3(kept);
    }
    if (OPACITY == 2) {
        s.high.a += t.high.a & kept;
        s.low.a += t.low.a & kept;
    }
    if ((AOVS & 2) != 0)
        s.fragments -= kept;
    if (KEY_IDS || !PACKED) // a slot that holds nothing may show an older frame's id
        s.near_encoded = counts && t.rank.low == near.low ? t.encoded : s.near_encoded;
}

vec4 sums_fine(Sums sums)
{
    return vec4(sums.high) * PART + vec4(sums.low);
}

// Their opacity; where the weights vanish, that of the nearest.
float sums_alpha(Sums sums, uint near_id)
{
    if (sums.weight == 0)
        return splat_opacity(near_id);
    return sums_fine(sums).a / (float(sums.weight) * (ALPHA_UNIT / UNIT));
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
    s.near_normal = normal_decode(PACKED && !KEY_IDS ? near.low & 0xfffffff : sums.near_encoded);
    s.near_depth = PACKED ? depth_restore(uint(near.depth)) : near.depth;
    float unit = PACKED ? frame.depth_scale : 1.0;
    s.depth = s.near_depth + float(sums.depth) / weight * (epsilon / unit);
    s.albedo = sums_fine(sums).rgb / frame.color_scale;
    return s;
}

// Of the layer that starts there, in the units of depths.
float rank_epsilon(Rank near)
{
    return object_epsilon(rank_id(near)) * (PACKED ? frame.depth_scale : 1.0);
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
