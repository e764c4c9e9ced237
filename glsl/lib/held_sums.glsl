// Sums of the two-pass method that a thread holds of a pixel (lib/binned.glsl). A term is the same
// integer as sums_add makes of it, in two parts that each fit a word: what a software device converts
// and adds eight at a time.
#define BINNED_ROWS 4

const float PART = float(1 << STP_PART_BITS); // a term is below 2^41

struct Part {
    ivec4 high, low;
};

struct Held {
    float nearest, epsilon;
    Part normal, color; // weight and normal; colour and opacity
    int high, low;      // depth
    uint fragments;
};

const Part PART_NONE = Part(ivec4(0), ivec4(0));

Held held_begin(uint pixel)
{
    uint64_t first = sums_buffer().v[sums_at(pixel, 0)];
    bool any = first != STP_SUMS_NONE;
    return Held(depth_ordered(uint(first >> 32)), object_epsilon(any ? uint(first) : 0), PART_NONE,
                PART_NONE, 0, 0, 0);
}

void part_add(inout Part part, vec4 value, float scale, int kept)
{
    PRECISE vec4 v = round(value * scale), high = floor(v / PART);
    part.high += ivec4(high) & kept;
    part.low += ivec4(v - high * PART) & kept;
}

void held_take(inout Held held, bool hit, uint pixel, uint id, Splat s, Fragment f, uint encoded)
{
    bool counts = hit && !(f.depth > held.nearest + held.epsilon);
    int kept = counts ? -1 : 0; // selections would become branches
    vec3 n = fragment_normal(s, f);
    PRECISE float w = kernel_weight(f.rho2), scale = frame.sum_scale;
    part_add(held.normal, vec4(w * n, w), scale, kept);
    PRECISE float above = round(w * ((f.depth - held.nearest) / held.epsilon) * scale);
    float high = floor(above / PART);
    held.high += int(high) & kept;
    held.low += int(above - high * PART) & kept;
    if (HAS_COLOR || SHADE == 1)
        part_add(held.color, vec4(w * fragment_color(pixel, id, n, f), 0), frame.color_scale, kept);
    if ((AOVS & 2) != 0)
        held.fragments -= kept;
}

void held_put(uint pixel, uint word, int high, int low)
{
    uint at = sums_at(pixel, word);
    sums_buffer().v[at] += uint64_t(int64_t(high) * int64_t(PART) + int64_t(low));
}

void held_end(uint pixel, Held held)
{
    held_put(pixel, 1, held.normal.high.w, held.normal.low.w);
    for (uint i = 0; i < 3; i++)
        held_put(pixel, 2 + i, held.normal.high[i], held.normal.low[i]);
    held_put(pixel, 5, held.high, held.low);
    if (HAS_COLOR || SHADE == 1)
        for (uint i = 0; i < 3; i++)
            held_put(pixel, 6 + i, held.color.high[i], held.color.low[i]);
    if ((AOVS & 2) != 0)
        sums_buffer().v[sums_at(pixel, 9)] += held.fragments;
}
