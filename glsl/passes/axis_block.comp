#version 460
#extension GL_GOOGLE_include_directive : require
// The walks' splats on blocks of pixels, front to back. Eight threads are a block; each takes a part of
// a column and holds its pixels' sums in registers. Walk after walk, merged as each pixel's ray says
// (HM Eq. 1).
// PARTS: one walk, STP_AXIS_PART entries of its list at most, since a device may stop long loops;
// sums are kept in memory, and axis_merge.comp merges them.
// FETCHED: splats come as texels (lib/projected.glsl). A thread fetches by itself what its block's eight
// all take.
// SHUFFLED: a block's threads are a subgroup. Each fetches one splat of a turn, and all take the eight
// from each other: on a software device that is one instruction a word, where a broadcast is a loop.
#include "lib/common.glsl"
#ifdef SHUFFLED
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif
#include "lib/pixel.glsl"
#include "lib/axis.glsl"
#include "lib/axis_output.glsl"
#include "lib/ellipsoid.glsl"
#include "lib/gaussian.glsl"
layout(local_size_x = STP_GROUP) in;

const uint THREADS = 8;             // of a block
const uint ROWS = STP_AXIS_ROWS;    // pixels of a thread
const uint TURN = 8;                // entries a turn of the loop
// Of a picture's whole: what less light adds is left out. In sorted order that is below rounding;
// orders along axes are off by far more than 2^-17 (docs/results/axis.md).
const float DARK = 1.0 / (1 << 20), DIM = 1.0 / (1 << 17);
const uint SORTED = STP_AXIS_MERGE_BLEND + 3; // frame.axis.merge counts on as enum stp_axis_merge does
const float NOTHING = -1.0 / 0.0;   // log2 of no optical depth

struct Sums {
    vec4 color[STP_AXIS_ROWS]; // premultiplied; w: what light is left
    float depth[STP_AXIS_ROWS];
};

struct Splat {
    vec4 place; // centre, log2 of tau; of an ellipsoid tau
    vec3 color;
    vec3 r, s; // of an ellipsoid, its factor
    GaussianWords words; // of a surface's
};

// known false: it shall have no fragment.
Splat fetch(uint entry, bool known)
{
    uint id = order_at(entry);
    Splat s;
    if (DISCS) {
        s.words = gaussian_words(id);
        s.words.head.y = known ? s.words.head.y : 0;
        s.color = gaussian_color(s.words);
        return s;
    }
    if (ELLIPSOIDS) {
        Ellipsoid e = ellipsoid_load(id, s.color);
        s.place = vec4(e.centre, known ? e.tau : 0);
        s.r = e.r;
        s.s = e.s;
        return s;
    }
    s.place = projected_at(2 * id);
    s.color = projected_at(2 * id + 1).xyz;
    s.place.w = known ? s.place.w : NOTHING;
    return s;
}

// ray.d is the pixel itself where DISCS.
float alpha_of(Splat s, Ray ray, out float depth)
{
    if (DISCS)
        return gaussian_alpha(s.words, ray.d, depth);
    if (ELLIPSOIDS)
        return ellipsoid_alpha(Ellipsoid(s.place.xyz, s.place.w, s.r, s.s, vec3(0)), ray.d, depth);
    return axis_alpha(ray, s.place.xyz, s.place.w, depth);
}

// Entry n of a list counted from its end, where the nearest lies.
Splat fetch_at(uint end, uint n, uint count)
{
    return fetch(max(end, n + 1) - n - 1, n < count);
}

#ifdef SHUFFLED
uint thread()
{
    return gl_SubgroupID * THREADS + gl_SubgroupInvocationID;
}

Splat from_thread(Splat s, uint k)
{
    if (DISCS) {
        s.words.head = subgroupShuffle(s.words.head, k);
        s.words.s = subgroupShuffle(s.words.s, k);
        s.words.t = subgroupShuffle(s.words.t, k);
        s.words.v = subgroupShuffle(s.words.v, k);
        if (PHONG == 2) {
            s.words.clip[0] = subgroupShuffle(s.words.clip[0], k);
            s.words.clip[1] = subgroupShuffle(s.words.clip[1], k);
        }
        s.color = gaussian_color(s.words);
        return s;
    }
    s.place = subgroupShuffle(s.place, k);
    s.color = subgroupShuffle(s.color, k);
    if (ELLIPSOIDS) {
        s.r = subgroupShuffle(s.r, k);
        s.s = subgroupShuffle(s.s, k);
    }
    return s;
}

bool any_thread(bool still)
{
    uint any = still ? 1 : 0;
    [[unroll]] for (uint d = 1; d < THREADS; d *= 2)
        any |= subgroupShuffle(any, gl_SubgroupInvocationID ^ d);
    return any != 0;
}
#else
uint thread()
{
    return gl_LocalInvocationIndex;
}
#endif

// The nearest entry comes last in a list: from `end` backwards. dark: of each pixel, light that is
// too little to go on for.
void take(uint end, uint count, const Ray ray[STP_AXIS_ROWS], const float dark[STP_AXIS_ROWS],
          inout Sums sums)
{
    bool still = true;
    float left[STP_AXIS_ROWS]; // light of pixels that are dark
    [[unroll]] for (uint i = 0; i < ROWS; i++)
        left[i] = 0;
    for (uint n = 0; n < count && still; n += TURN) {
#ifdef SHUFFLED
        Splat mine = fetch_at(end, n + gl_SubgroupInvocationID, count);
#else
        Splat next[TURN]; // all before the first is needed: loads wait side by side
        [[unroll]] for (uint k = 0; k < TURN; k++)
            next[k] = fetch_at(end, n + k, count);
#endif
        [[unroll]] for (uint k = 0; k < TURN; k++) {
#ifdef SHUFFLED
            Splat s = from_thread(mine, k);
#else
            Splat s = next[k];
#endif
            [[unroll]] for (uint i = 0; i < ROWS; i++) {
                float depth;
                float w = sums.color[i].w * alpha_of(s, ray[i], depth);
                sums.color[i] += vec4(w * s.color, -w);
                sums.depth[i] += DISCS && w == 0 ? 0 : w * depth; // a plane may be met nowhere
            }
        }
        still = false; // a pixel that is dark stays as it is, whatever its neighbours need
        [[unroll]] for (uint i = 0; i < ROWS; i++) {
            bool lit = sums.color[i].w > dark[i];
            left[i] += lit ? 0 : sums.color[i].w;
            sums.color[i].w = lit ? sums.color[i].w : 0;
            still = still || lit;
        }
#ifdef SHUFFLED
        still = any_thread(still); // none leaves a loop in which others take from it
#endif
    }
    [[unroll]] for (uint i = 0; i < ROWS; i++)
        sums.color[i].w += left[i];
}

// The list of a walk: its end and length.
void find(uint walk, uvec2 pixel, out uint end, out uint count)
{
    uint list = (walk * frame.axis.blocks_y + pixel.y / STP_AXIS_HEIGHT) * frame.axis.blocks_x +
                pixel.x / STP_AXIS_WIDTH;
    end = frame.counts.v[list + 1];
    count = end - frame.counts.v[list];
}

#ifdef PARTS
void walk(uvec2 p, const Ray ray[STP_AXIS_ROWS])
{
    uint end, count, done = AXIS_PART * STP_AXIS_PART;
    Sums sums;
    float dark[STP_AXIS_ROWS];
    find(AXIS_WALK, p + uvec2(frame.tile_x, frame.tile_y), end, count);
    [[unroll]] for (uint i = 0; i < ROWS; i++) {
        uint from = axis_sum(p + uvec2(0, i), AXIS_WALK);
        sums.color[i] = AXIS_PART > 0 ? frame.axis_sums.v[from] : vec4(0, 0, 0, 1);
        sums.depth[i] = AXIS_PART > 0 ? frame.axis_sums.v[from + 1].x : 0;
        dark[i] = DARK;
    }
    take(end - min(done, count), done < count ? min(count - done, STP_AXIS_PART) : 0, ray, dark,
         sums);
    [[unroll]] for (uint i = 0; i < ROWS; i++) {
        uint to = axis_sum(p + uvec2(0, i), AXIS_WALK);
        frame.axis_sums.v[to] = sums.color[i];
        frame.axis_sums.v[to + 1] = vec4(sums.depth[i], 0, 0, 0);
    }
}
#else
// A pixel is dark when what a walk could still add, by its share of the weights, is below DARK; where
// it has no weight it is from the start.
void walk(uvec2 p, const Ray ray[STP_AXIS_ROWS])
{
    vec3 v[STP_AXIS_ROWS];
    vec4 color[STP_AXIS_ROWS];
    float total[STP_AXIS_ROWS], depth[STP_AXIS_ROWS];
    [[unroll]] for (uint i = 0; i < ROWS; i++) {
        v[i] = axis_world_ray(vec2(p.x, p.y + i) + 0.5 + vec2(frame.tile_x, frame.tile_y));
        color[i] = vec4(0);
        depth[i] = total[i] = 0;
        for (uint n = 0; n < AXIS_WALKS; n++) {
            float w = axis_weight(frame.axis.walk[n], v[i]);
            total[i] += w * w;
        }
    }
    for (uint n = 0; n < AXIS_WALKS; n++) {
        uint end, count;
        Sums sums;
        float share[STP_AXIS_ROWS], dark[STP_AXIS_ROWS];
        find(n, p + uvec2(frame.tile_x, frame.tile_y), end, count);
        [[unroll]] for (uint i = 0; i < ROWS; i++) {
            float w = axis_weight(frame.axis.walk[n], v[i]);
            share[i] = total[i] > 0 ? w * w / total[i] : 0;
            dark[i] = share[i] > 0 ? (frame.axis.merge == SORTED ? DARK : DIM) / share[i] : 2;
            sums.color[i] = vec4(0, 0, 0, 1);
            sums.depth[i] = 0;
        }
        take(end, count, ray, dark, sums);
        [[unroll]] for (uint i = 0; i < ROWS; i++) {
            color[i] += share[i] * vec4(sums.color[i].xyz, 1 - sums.color[i].w);
            depth[i] += share[i] * sums.depth[i];
        }
    }
    [[unroll]] for (uint i = 0; i < ROWS; i++)
        if (p.x < frame.tile_width && p.y + i < frame.tile_height)
            axis_output(p + uvec2(0, i), color[i], depth[i]);
}
#endif

void main()
{
    const uint of_block = STP_BLOCK * STP_BLOCK / (STP_AXIS_WIDTH * STP_AXIS_HEIGHT); // the picture's
    uint block = workgroup_index() * (STP_GROUP / THREADS) + thread() / THREADS;
    uint across = frame.blocks_x * (STP_BLOCK / STP_AXIS_WIDTH), t = thread() % THREADS;
    if (block >= frame.blocks_x * frame.blocks_y * of_block)
        return;
    uvec2 p = uvec2(block % across * STP_AXIS_WIDTH + t % STP_AXIS_WIDTH,
                    block / across * STP_AXIS_HEIGHT + t / STP_AXIS_WIDTH * ROWS);
    Ray ray[STP_AXIS_ROWS];
    [[unroll]] for (uint i = 0; i < ROWS; i++) {
        vec2 pixel = vec2(p.x, p.y + i) + vec2(frame.tile_x, frame.tile_y);
        if (DISCS)
            ray[i].d = pixel;
        else
            ray[i] = axis_ray(pixel + 0.5);
    }
    walk(p, ray);
}
