#version 460
#extension GL_GOOGLE_include_directive : require
// The walks' splats on blocks of pixels, front to back. A thread takes a column of its block and holds
// its pixels' sums in registers: a splat is fetched once for the column. Walk after walk, merged as
// each pixel's ray says (HM Eq. 1).
// PARTS: one walk, STP_AXIS_PART entries of its list at most, since a device may stop long loops;
// sums are kept in memory, and axis_merge.comp merges them.
// FETCHED: splats come as texels (lib/projected.glsl). A thread fetches by itself what its block's eight
// all take: a broadcast by subgroup is a loop on a software device, and costs more.
#include "lib/common.glsl"
#include "lib/pixel.glsl"
#include "lib/axis.glsl"
#include "lib/axis_output.glsl"
#include "lib/ellipsoid.glsl"
#include "lib/gaussian.glsl"
layout(local_size_x = STP_GROUP) in;

const uint COLUMNS = STP_BLOCK, ROWS = STP_AXIS_ROWS;
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

// The nearest entry comes last in a list: from `end` backwards. dark: of each pixel, light that is
// too little to go on for.
void take(uint end, uint count, const Ray ray[STP_AXIS_ROWS], const float dark[STP_AXIS_ROWS],
          inout Sums sums)
{
    bool still = true;
    float left[STP_AXIS_ROWS] = float[](0, 0, 0, 0); // light of pixels that are dark
    for (uint n = 0; n < count && still; n += TURN) {
        Splat next[TURN]; // all before the first is needed: loads wait side by side
        [[unroll]] for (uint k = 0; k < TURN; k++)
            next[k] = fetch(max(end, n + k + 1) - n - k - 1, n + k < count);
        [[unroll]] for (uint k = 0; k < TURN; k++) {
            Splat s = next[k];
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
    }
    [[unroll]] for (uint i = 0; i < ROWS; i++)
        sums.color[i].w += left[i];
}

// The list of a walk: its end and length.
void find(uint walk, uvec2 pixel, out uint end, out uint count)
{
    uint list = (walk * frame.axis.blocks_y + pixel.y / ROWS) * frame.axis.blocks_x +
                pixel.x / COLUMNS;
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
    const uint bands = STP_BLOCK / ROWS; // of one block of the picture
    uint block = workgroup_index() * (STP_GROUP / COLUMNS) + gl_LocalInvocationIndex / COLUMNS;
    uint column = gl_LocalInvocationIndex % COLUMNS;
    if (block >= frame.blocks_x * frame.blocks_y * bands)
        return;
    uvec2 p = uvec2(block % frame.blocks_x * COLUMNS + column, block / frame.blocks_x * ROWS);
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
