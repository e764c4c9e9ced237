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

// The product of a colour of 12 bits and of a weight has 36: by halves of the weight's 24, 64 of them stay
// below 2^31.
const int HALF_BITS = 12;
const int COLOR_PART_BITS = COLOR_CODES ? HALF_BITS : STP_PART_BITS;

const float NEVER = 1.0 / 0.0;

// Of a splat without a normal field the key holds the id, and the splat's traits the normal: one word less
// to write and to read a fragment.
const bool TRAITS = KEY_IDS && PHONG == 0;
const uint TRAITS_OPAQUE = STP_TRAITS_IDS; // above the id
const bool SLOT_IDS = KEY_IDS && !TRAITS;

struct Traits {
    uint normal, color; // packed: traits_make
};

struct Slot {
    uvec2 key;
    uint id; // with SLOT_OPAQUE; SLOT_IDS only
};

// The nearest fragment has the least rank: equal depths go to the lower id where there are ids.
struct Rank {
    float depth; // in quantised steps when packed; NEVER: there is no fragment
    uint low;    // slot_word; the key's lower word where there are no ids
};

// What a fragment adds to sums: the same for every layer that might take it.
struct Term {
    Rank rank;
    Traits traits;
    int weight;   // in UNITs, as the rest, which is multiplied with it
    ivec3 normal;
    // Opacity in ALPHA_UNITs, and without COLOR_CODES colour in units of color_scale; high: PARTs of them.
    ivec4 high, low;
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
const Traits TRAITS_NONE = Traits(0, 0);
const Term TERM_NONE = Term(RANK_NONE, TRAITS_NONE, 0, ivec3(0), ivec4(0), ivec4(0));
const Sums SUMS_NONE = Sums(SUM(0), SUM(0), SUM3(0), SUM4(0), SUM4(0), 0, 0);

// The normal in 28 bits; with COLOR_CODES a colour of 0 to 1 in three of 12, 4 of them above the normal.
Traits traits_make(uint id, Splat s)
{
    Traits t = Traits(normal_encode(s.normal), 0);
    if (COLOR_CODES) {
        precise vec3 steps = frame.colors.v[id] * float(STP_COLOR_STEPS) + 0.5;
        uvec3 c = uvec3(steps);
        t.normal |= c.r << 28;
        t.color = c.r >> 4 << 24 | c.g << 12 | c.b;
    }
    return t;
}

ivec3 traits_color(Traits t)
{
    return ivec3(t.normal >> 28 | t.color >> 24 << 4, t.color >> 12 & 4095, t.color & 4095);
}

#ifndef FETCHED
Traits traits_read(uint id)
{
    uvec2 words = unpackUint2x32(frame.traits.v[id]);
    return Traits(words.x, words.y);
}
#endif

void traits_write(uint id, Traits traits)
{
    frame.traits.v[id] = packUint2x32(uvec2(traits.normal, traits.color));
}

// What all fragments of a splat share of a slot.
uint slot_encode(Splat s)
{
    return PACKED && PHONG == 0 && !TRAITS ? normal_encode(s.normal) : 0;
}

// encoded: slot_encode of the splat.
Slot slot_make(uint id, Splat s, Fragment f, uint encoded)
{
    uint opaque = MIXED ? s.tag & STP_TAG_OPAQUE : 0;
    uint word = id | opaque * (SLOT_OPAQUE / STP_TAG_OPAQUE);
    if (!PACKED)
        return Slot(unpackUint2x32(key_id(f, word)), word);
    uint low = TRAITS ? id | opaque * (TRAITS_OPAQUE / STP_TAG_OPAQUE) : fragment_encode(s, f, encoded);
    return Slot(key_words(f, low), word);
}

// The word that holds the id, and whether the splat is opaque; the key's lower one where there are no ids.
uint slot_word(Slot slot)
{
    if (!TRAITS)
        return SLOT_IDS ? slot.id : slot.key.x;
    uint id = slot.key.x & TRAITS_OPAQUE - 1, opaque = slot.key.x & TRAITS_OPAQUE;
    return MIXED ? id | opaque * (SLOT_OPAQUE / TRAITS_OPAQUE) : id;
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

// The normal n, which the traits hold packed.
Term term_make(Rank rank, bool present, float rho2, vec3 n, Traits traits)
{
    Term t;
    uint known = present ? rank_id(rank) : 0;
    float w = kernel_weight(rho2);
    t.rank = rank;
    t.traits = traits;
    t.weight = int(round(w * UNIT));
    t.normal = ivec3(round(n * (w * UNIT)));
    vec4 fine = vec4(0);
    if (HAS_COLOR && !COLOR_CODES)
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
    int weight = t.weight & kept;
    s.weight += SUM(weight);
    s.normal += t.normal & ivec3(kept);
    s.depth += depth & kept;
    if (COLOR_CODES) {
        ivec3 color = traits_color(t.traits);
        s.high.rgb += SUM3(color * (weight >> HALF_BITS));
        s.low.rgb += SUM3(color * (weight & (1 << HALF_BITS) - 1));
    } else if (HAS_COLOR) {
        s.high.rgb += t.high.rgb & ivec3(kept);
        s.low.rgb += t.low.rgb & ivec3(kept);
    }
    if (OPACITY == 2) {
        s.high.a += t.high.a & kept;
        s.low.a += t.low.a & kept;
    }
    if ((AOVS & 2) != 0)
        s.fragments -= kept;
    if (SLOT_IDS || !PACKED) // a slot that holds nothing may show an older frame's id
        s.near_encoded = counts && t.rank.low == near.low ? t.traits.normal : s.near_encoded;
}

// Of the layer that starts there, in the units of depths.
float rank_epsilon(Rank near)
{
    return object_epsilon(rank_id(near)) * (PACKED ? frame.depth_scale : 1.0);
}
