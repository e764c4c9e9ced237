/* What processes that make one picture tell each other: of every pixel the nearest fragment, to
 * all; that fragment's splat and the sums, to the root. Only pixels that have a fragment anywhere
 * are sent, chunk by chunk; each chunk begins with the agreement that nobody has failed, so that
 * nobody waits for one who has. */
#include "record/record.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/scene.h"

struct exchange {
    const struct stp_env *env;
    struct record_frame *frame;
    struct record_share *share;
    const struct stp_scene *scene;
    uint32_t sample;
    uint32_t first, count; /* pixels of the chunk */
    uint32_t hits;
    uint64_t *sums;             /* of the chunk */
    uint32_t stride;            /* of those, words a pixel */
    unsigned words;             /* values a hit */
    unsigned of[STP_SUM_WORDS]; /* SUMS: which words of a pixel's sums they are */
};

enum stp_result record_share_create(const struct stp_env *env, const struct stp_plan *plan,
                                    const struct stp_machines *machines, struct record_share *share)
{
    struct record_share made = { .machines = machines };
    size_t ghosts = (size_t)plan_ghosts(plan) * plan_samples(plan);
    bool ids = plan_is_root(plan) && (plan->params.aovs & STP_AOV_ID);
    made.values = mem_alloc(RECORD_CHUNK * RECORD_MOST_VALUES, sizeof *made.values);
    made.sums = mem_alloc(RECORD_CHUNK * STP_SUM_WORDS, sizeof *made.sums);
    made.hit = mem_alloc(RECORD_CHUNK, sizeof *made.hit);
    made.ghost = plan_is_root(plan) ? mem_alloc(RECORD_CHUNK, sizeof *made.ghost) : NULL;
    made.ghost_color = plan_is_root(plan) && plan->facts.has_color
                           ? mem_alloc(RECORD_CHUNK, sizeof *made.ghost_color)
                           : NULL;
    made.ghost_input = ids ? mem_alloc(ghosts, sizeof *made.ghost_input) : NULL;
    bool ghosts_there =
        !plan_is_root(plan) || (made.ghost && (made.ghost_color || !plan->facts.has_color));
    if (made.values && made.sums && made.hit && ghosts_there && (made.ghost_input || !ids)) {
        *share = made;
        return STP_OK;
    }
    record_share_destroy(&made);
    return log_no_memory(env, ids ? ghosts * sizeof *made.ghost_input : RECORD_CHUNK * 8,
                         "what processes exchange");
}

void record_share_destroy(struct record_share *share)
{
    mem_free(share->values);
    mem_free(share->sums);
    mem_free(share->hit);
    mem_free(share->ghost);
    mem_free(share->ghost_color);
    mem_free(share->ghost_input);
    *share = (struct record_share){ 0 };
}

enum stp_result record_agree(struct record_share *share, enum stp_result mine)
{
    enum stp_result result = share->machines->agree(share->machines->user, mine);
    share->agreed = result != STP_OK;
    return result;
}

static struct gpu_buffer *buffer_of(struct record_frame *frame, enum plan_slot slot)
{
    uint8_t i = plan_find(frame->plan, slot);
    return i == PLAN_NONE ? NULL : &frame->resources.buffer[i];
}

enum stp_result record_ghosts(const struct stp_env *env, struct record_frame *frame)
{
    const struct stp_plan *plan = frame->plan;
    enum stp_result result = STP_OK;
    if (plan_is_root(plan))
        return STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < plan->facts.objects; i++) {
        float ghost[8] = { 0 };
        uint32_t tag = i << 8;
        memcpy(&ghost[7], &tag, sizeof tag);
        result = gpu_upload_at(env, frame->context, buffer_of(frame, PLAN_SPLATS),
                               ((size_t)plan_splats(plan) + i) * sizeof ghost, ghost, sizeof ghost);
    }
    return result;
}

uint32_t record_ghost_input(const struct record_frame *frame, uint32_t id, uint32_t sample)
{
    size_t ghost = id - (size_t)plan_splats(frame->plan);
    return frame->share->ghost_input[(size_t)plan_ghosts(frame->plan) * sample + ghost];
}

/* A chunk of the sums, as the host sees it. */
#define PIXEL_BYTES (x->stride * sizeof(uint64_t))

static enum stp_result open_chunk(struct exchange *x)
{
    struct gpu_buffer *sums = buffer_of(x->frame, PLAN_SUMS);
    char *view = gpu_view(sums);
    x->sums = view ? (uint64_t *)(view + x->first * PIXEL_BYTES) : x->share->sums;
    return view ? STP_OK
                : gpu_download(x->env, x->frame->context, sums, x->first * PIXEL_BYTES, x->sums,
                               x->count * PIXEL_BYTES);
}

static enum stp_result close_chunk(struct exchange *x)
{
    struct gpu_buffer *sums = buffer_of(x->frame, PLAN_SUMS);
    return gpu_view(sums) ? STP_OK
                          : gpu_upload_at(x->env, x->frame->context, sums, x->first * PIXEL_BYTES,
                                          x->sums, x->count * PIXEL_BYTES);
}

/* Keys hold the depth above the id: their minimum is the nearest, the lower id among equals. Ids
 * are of the whole scene while they travel. */
static void gather_keys(struct exchange *x)
{
    uint64_t first = x->scene->share.first;
    for (uint32_t i = 0; i < x->count; i++) {
        uint64_t key = x->sums[i * x->stride];
        x->share->values[i] = (int64_t)(key == STP_SUMS_NONE ? key : key + first);
    }
}

static void take_keys(struct exchange *x)
{
    x->hits = 0;
    for (uint32_t i = 0; i < x->count; i++) {
        uint64_t key = (uint64_t)x->share->values[i];
        x->sums[i * x->stride] = key;
        if (key != STP_SUMS_NONE)
            x->share->hit[x->hits++] = i;
    }
}

/* What resolving asks of a splat, in three values or five. */
struct winner {
    float normal[3];
    uint32_t tag;
    uint32_t input, pad;
    float color[4];
};
_Static_assert(sizeof(struct winner) == 5 * sizeof(int64_t), "whole values");

/* The splat's index in this process's share. */
static bool is_mine(const struct exchange *x, uint32_t id, size_t *index)
{
    *index = (size_t)id - x->scene->share.first;
    return id >= x->scene->share.first && *index < x->scene->splats.count;
}

/* One process knows each winner; from the others come zeros, and the sum is its bits. */
static void gather_winners(struct exchange *x)
{
    const struct splats *s = &x->scene->splats;
    for (uint32_t h = 0; h < x->hits; h++) {
        struct winner winner = { 0 };
        size_t i;
        if (is_mine(x, (uint32_t)x->sums[x->share->hit[h] * x->stride], &i)) {
            memcpy(winner.normal, s->normal[i], sizeof winner.normal);
            winner.tag = s->object ? (uint32_t)s->object[i] << 8 : 0;
            winner.input = s->input[i];
            if (s->color)
                memcpy(winner.color, s->color[i], sizeof *s->color);
        }
        memcpy(x->share->values + h * x->words, &winner, x->words * sizeof(int64_t));
    }
}

/* The root: what another process's splat needs here. */
static void make_ghost(struct exchange *x, uint32_t pixel, const struct winner *winner)
{
    size_t ghosts = (size_t)plan_ghosts(x->frame->plan);
    float *ghost = x->share->ghost[pixel];
    memset(ghost, 0, sizeof x->share->ghost[pixel]);
    memcpy(ghost + 4, winner->normal, sizeof winner->normal);
    memcpy(ghost + 7, &winner->tag, sizeof winner->tag);
    if (x->share->ghost_color)
        memcpy(x->share->ghost_color[pixel], winner->color, sizeof *x->share->ghost_color);
    if (x->share->ghost_input)
        x->share->ghost_input[ghosts * x->sample + x->first + pixel] = winner->input;
}

static enum stp_result upload_ghosts(struct exchange *x)
{
    size_t at = (size_t)plan_splats(x->frame->plan) + x->first;
    if (!plan_is_root(x->frame->plan))
        return STP_OK;
    enum stp_result result = gpu_upload_at(
        x->env, x->frame->context, buffer_of(x->frame, PLAN_SPLATS), at * sizeof *x->share->ghost,
        x->share->ghost, x->count * sizeof *x->share->ghost);
    if (result == STP_OK && x->share->ghost_color)
        result = gpu_upload_at(x->env, x->frame->context, buffer_of(x->frame, PLAN_COLORS),
                               at * sizeof *x->share->ghost_color, x->share->ghost_color,
                               x->count * sizeof *x->share->ghost_color);
    return result;
}

/* Ids of this process's own splats again, and of ghosts for the others'. */
static enum stp_result place_winners(struct exchange *x)
{
    const struct stp_plan *plan = x->frame->plan;
    uint32_t own = (uint32_t)plan_splats(plan);
    for (uint32_t h = 0; h < x->hits; h++) {
        uint32_t pixel = x->share->hit[h];
        uint64_t *key = &x->sums[pixel * x->stride];
        struct winner winner = { 0 };
        size_t id;
        memcpy(&winner, x->share->values + h * x->words, x->words * sizeof(int64_t));
        if (!is_mine(x, (uint32_t)*key, &id) && plan_is_root(plan)) {
            id = own + x->first + pixel;
            make_ghost(x, pixel, &winner);
        } else if (!is_mine(x, (uint32_t)*key, &id)) {
            id = own + (plan->facts.objects > 1 ? winner.tag >> 8 : 0);
        }
        *key = *key >> 32 << 32 | (uint32_t)id;
    }
    return upload_ghosts(x);
}

static void reduce(const struct exchange *x, enum stp_reduction reduction, size_t count,
                   bool to_all)
{
    const struct stp_machines *m = x->share->machines;
    m->reduce(m->user, reduction, x->share->values, count, to_all);
}

static enum stp_result exchange_nearest(struct exchange *x)
{
    gather_keys(x);
    reduce(x, STP_REDUCE_MINIMUM, x->count, true);
    take_keys(x);
    gather_winners(x);
    reduce(x, STP_REDUCE_SUM, (size_t)x->hits * x->words, x->frame->plan->facts.objects > 1);
    return place_winners(x);
}

/* Resolving visits the blocks that are flagged: those that any process touched. */
static enum stp_result flag_blocks(struct exchange *x)
{
    uint32_t flags[RECORD_CHUNK / STP_GROUP] = { 0 };
    for (uint32_t h = 0; h < x->hits; h++)
        flags[x->share->hit[h] / STP_GROUP] = STP_BLOCK_TOUCHED;
    return gpu_upload_at(x->env, x->frame->context, buffer_of(x->frame, PLAN_WORK),
                         (STP_WORK_FLAGS + x->first / STP_GROUP) * sizeof *flags, flags,
                         x->count / STP_GROUP * sizeof *flags);
}

static enum stp_result exchange_sums(struct exchange *x)
{
    int64_t *values = x->share->values;
    x->hits = 0;
    for (uint32_t i = 0; i < x->count; i++) {
        const uint64_t *sums = &x->sums[i * x->stride];
        if (sums[0] == STP_SUMS_NONE)
            continue;
        for (unsigned w = 0; w < x->words; w++)
            values[x->hits * x->words + w] = (int64_t)sums[x->of[w]];
        x->share->hit[x->hits++] = i;
    }
    reduce(x, STP_REDUCE_SUM, (size_t)x->hits * x->words, false);
    if (!plan_is_root(x->frame->plan))
        return STP_OK;
    for (uint32_t h = 0; h < x->hits; h++)
        for (unsigned w = 0; w < x->words; w++)
            x->sums[x->share->hit[h] * x->stride + x->of[w]] = (uint64_t)values[h * x->words + w];
    return flag_blocks(x);
}

/* glsl/lib/sums.glsl says which words there are; what the picture does not use is not sent. */
static void choose_words(struct exchange *x, const struct plan_pass *pass)
{
    const uint32_t *constant = x->frame->plan->constant;
    if (pass->exchange == PLAN_EXCHANGE_NEAREST) {
        bool ids = (x->frame->plan->params.aovs & STP_AOV_ID) != 0;
        x->words = constant[PLAN_HAS_COLOR] ? 5 : ids ? 3 : 2;
        return;
    }
    for (unsigned word = 1; word < STP_SUM_WORDS; word++)
        if (word < 6 || (word < 9 ? constant[PLAN_HAS_COLOR] : constant[PLAN_AOVS] & 2))
            x->of[x->words++] = word;
}

static enum stp_result exchange_chunk(struct exchange *x, const struct plan_pass *pass,
                                      enum stp_result mine)
{
    enum stp_result result = mine == STP_OK ? open_chunk(x) : mine;
    result = record_agree(x->share, result);
    if (result != STP_OK)
        return result;
    result = pass->exchange == PLAN_EXCHANGE_NEAREST ? exchange_nearest(x) : exchange_sums(x);
    return result == STP_OK ? close_chunk(x) : result;
}

enum stp_result record_exchange(const struct stp_env *env, struct record_frame *frame,
                                const struct stp_scene *scene, const struct plan_pass *pass,
                                uint32_t sample, enum stp_result mine)
{
    struct exchange x = { .env = env,
                          .frame = frame,
                          .share = frame->share,
                          .scene = scene,
                          .sample = sample,
                          .stride = plan_sum_words(frame->plan) };
    uint32_t pixels = (uint32_t)plan_pixels(frame->plan);
    choose_words(&x, pass);
    for (x.first = 0; x.first < pixels && !x.share->agreed; x.first += RECORD_CHUNK) {
        x.count = pixels - x.first < RECORD_CHUNK ? pixels - x.first : RECORD_CHUNK;
        mine = exchange_chunk(&x, pass, mine);
    }
    return mine;
}
