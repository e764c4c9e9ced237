// What exact keeps of a fragment, and sums of fragments in integers, so that the order in which they come
// does not matter: the same for pixels that are resolved from slots, from lists, and layer by layer.
// Needs key.glsl.

// WIDE: of any number of fragments. Else 64, whose weights and normals stay below 2^31.
#ifdef WIDE
#define SUM  int64_t
#define SUM3 i64vec3
#define SUM4 i64vec4
#else
#define SUM  int
#define SUM3 ivec3
#define SUM4 ivec4
#endif
const float UNIT = STP_WEIGHT_UNIT;
// Colour and opacity are finer, 2^40: an opacity of 1e-6 keeps its own. They come in two parts that
// each fit a word, since a software device converts and adds words eight at a time.
const float ALPHA_UNIT = 1099511627776.0, PART = float(1 << STP_PART_BITS);

// Of a slot's id word: the splat is opaque, where not all are.
const uint SLOT_OPAQUE = 0x80000000u;

const float NEVER = 1.0 / 0.0;

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

uint slot_encode(Splat s)
{
    return PACKED && PHONG == 0 ? normal_encode(s.normal) : 0;
}

// encoded: slot_encode of the splat.
Slot slot_make(uint id, Splat s, Fragment f, uint encoded)
{
    uint word = MIXED ? id | (s.tag & STP_TAG_OPAQUE) << 24 : id; // STP_TAG_OPAQUE to SLOT_OPAQUE
    uvec2 key = PACKED ? key_words(f, fragment_encode(s, f, encoded)) : unpackUint2x32(key_id(f, word));
    return Slot(key, word);
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

// The normal n, which is packed as `encoded`.
Term term_make(Rank rank, bool present, float rho2, vec3 n, uint encoded)
{
    Term t;
    uint known = present ? rank_id(rank) : 0;
    float w = kernel_weight(rho2);
    t.rank = rank;
    t.encoded = encoded;
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

// Of the layer that starts there, in the units of depths.
float rank_epsilon(Rank near)
{
    return object_epsilon(rank_id(near)) * (PACKED ? frame.depth_scale : 1.0);
}
