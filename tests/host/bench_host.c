/* What a host's frame costs beside stp_render of the same picture: a Markdown table. The two take
 * turns, so that what else the machine does falls on both; docs/results/host.md was made with it.
 *   bench_host [SIZE [ROUNDS [POINTS...]]]    512, 7, 100 100000 1000000 */
#include "stage.h"

#include <math.h>
#include <time.h>

#define FRAMES      3 /* a round, of each */
#define MOST_ROUNDS 99

static const struct way {
    const char *name;
    struct stp_render_params params;
    float opacity;
} ways[] = {
    { "exact", { .method = STP_METHOD_EXACT }, 1 },
    { "exact, transparent", { .method = STP_METHOD_EXACT }, 0.5f },
    { "deferred, compute", { .method = STP_METHOD_DEFERRED, .path = STP_PATH_COMPUTE }, 1 },
    { "two-pass, compute", { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE }, 1 },
    { "two-pass, raster", { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER }, 1 },
};

static double now(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, unsigned count)
{
    qsort(values, count, sizeof *values, by_value);
    return values[count / 2];
}

/* The same scene twice: on a context of our own, and in the host's frame. */
struct pair {
    struct stage *s;
    struct stp_scene *scene;
    struct stp_context *own;
    struct stp_plan *own_plan, *plan;
    struct stp_resident *resident;
    struct stp_frame *frame;
};

static struct pair open_pair(struct stage *s, const struct way *way, size_t points, uint32_t size)
{
    const struct stp_context_params plain = { 0 };
    const struct stp_host_frame_params host = { .color_format = s->color.format,
                                                .depth_format = s->depth.format,
                                                .depth_reversed = true };
    struct pair p = { .s = s, .scene = stage_ball(&s->engine, points, true, 1, way->opacity) };
    s->camera = stage_view(p.scene, size, size, 0.4);
    p.plan = stage_plan(&s->engine, s->context, p.scene, &s->camera, &way->params);
    p.resident = stage_resident(&s->engine, s->context, p.scene, p.plan, NULL);
    p.frame = stage_frame(&s->engine, s->context, p.plan, &host);
    assert_int_equal(stp_context_create(NULL, &plain, &p.own), STP_OK);
    assert_int_equal(stp_plan_create(NULL, p.scene, &s->camera, &way->params,
                                     stp_context_limits(p.own), &p.own_plan),
                     STP_OK);
    return p;
}

static void close_pair(struct pair *p)
{
    stp_frame_destroy(&p->frame);
    stp_resident_destroy(&p->resident);
    stp_plan_destroy(&p->plan);
    stp_plan_destroy(&p->own_plan);
    stp_context_destroy(&p->own);
    stp_scene_destroy(&p->scene);
}

/* From record to fence; *record_ms gets the CPU's time of recording. */
static double hosted(struct pair *p, double *record_ms)
{
    struct engine *e = &p->s->engine;
    struct stp_targets targets = stage_targets(p->s);
    VkCommandBuffer commands = engine_begin(e, 0);
    stage_clear(commands, p->s, NULL, 0);
    engine_submit(e, 0);
    engine_finish(e); /* the host's own work is not ours */
    commands = engine_begin(e, 0);
    double start = now(CLOCK_MONOTONIC), cpu = now(CLOCK_THREAD_CPUTIME_ID);
    assert_int_equal(
        stp_frame_record(NULL, p->frame, p->resident, &p->s->camera, &targets, commands), STP_OK);
    *record_ms = now(CLOCK_THREAD_CPUTIME_ID) - cpu;
    engine_submit(e, 0);
    engine_finish(e);
    return now(CLOCK_MONOTONIC) - start;
}

static double offline(struct pair *p)
{
    struct stp_image *image = NULL;
    struct stp_render_stats stats;
    assert_int_equal(stp_render(NULL, p->own, p->scene, p->own_plan, FRAMES, &image, &stats),
                     STP_OK);
    stp_image_destroy(&image);
    return stats.frame_ms_median;
}

static void row(struct stage *s, const struct way *way, size_t points, uint32_t size,
                unsigned rounds)
{
    double theirs[MOST_ROUNDS], ours[MOST_ROUNDS], ratio[MOST_ROUNDS], frame[FRAMES];
    double record[MOST_ROUNDS * FRAMES], first;
    struct pair p = open_pair(s, way, points, size);
    hosted(&p, &first); /* shaders are compiled */
    for (unsigned r = 0; r < rounds; r++) {
        for (unsigned i = 0; i < FRAMES; i++)
            frame[i] = hosted(&p, &record[r * FRAMES + i]);
        theirs[r] = median(frame, FRAMES);
        ours[r] = offline(&p);
        ratio[r] = theirs[r] / ours[r];
    }
    double middle = median(ratio, rounds);
    printf("| %s | %zu | %.2f | %.2f | %.2f (%.2f to %.2f) | %.3f |\n", way->name, points,
           median(ours, rounds), median(theirs, rounds), middle, ratio[0], ratio[rounds - 1],
           median(record, rounds * FRAMES));
    fflush(stdout);
    close_pair(&p);
}

int main(int count, char **values)
{
    static const char *const defaults[] = { "100", "100000", "1000000" };
    uint32_t size = count > 1 ? (uint32_t)atoi(values[1]) : 512;
    unsigned rounds = count > 2 ? (unsigned)atoi(values[2]) : 7;
    struct stage s;
    if (size == 0 || rounds == 0 || rounds > MOST_ROUNDS) {
        fprintf(stderr, "bench_host [SIZE [ROUNDS [POINTS...]]]\n");
        return 2;
    }
    stage_open(&s, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_D32_SFLOAT, "validation");
    engine_image_close(&s.engine, &s.color);
    engine_image_close(&s.engine, &s.depth);
    engine_image_open(&s.engine, VK_FORMAT_R16G16B16A16_SFLOAT, size, size, &s.color);
    engine_image_open(&s.engine, VK_FORMAT_D32_SFLOAT, size, size, &s.depth);
    printf("| method | points | offline ms | in a host's frame ms | ratio (least to most) | CPU ms "
           "to record |\n|---|---:|---:|---:|---:|---:|\n");
    for (unsigned w = 0; w < sizeof ways / sizeof *ways; w++)
        for (int i = 0; i < (count > 3 ? count - 3 : 3); i++) {
            const char *points = count > 3 ? values[3 + i] : defaults[i];
            row(&s, &ways[w], strtoul(points, NULL, 10), size, rounds);
        }
    stage_close(&s);
    return 0;
}
