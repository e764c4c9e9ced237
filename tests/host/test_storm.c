/* A thousand frames, three in flight, with random sizes, scenes, cameras and methods, without a
 * message from core, synchronisation or best-practice validation; and two threads that record at
 * once. */
#include "stage.h"

#include <math.h>
#include <pthread.h>
#include <time.h>

#define SCENES 3
#define WAYS   2
#define FRAMES 1000

static const struct stp_render_params ways[WAYS] = {
    { .method = STP_METHOD_EXACT },
    { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER },
};

/* One scene by one method: its frames in flight share pipelines. */
struct drawn {
    struct stp_scene *scene;
    struct stp_plan *plan;
    struct stp_resident *resident;
    struct stp_frame *frame[ENGINE_FRAMES];
};

static struct drawn open_drawn(struct stage *s, unsigned scene, unsigned way)
{
    float opacity = scene == 1 && way == 0 ? 0.5f : 1; /* two-pass draws no layers */
    struct drawn d = { .scene = stage_ball(&s->engine, 200 + 300 * scene, scene != 1, 1 + scene,
                                           opacity) };
    struct stp_camera largest = stage_view(d.scene, WIDTH, HEIGHT, 0);
    struct stp_host_frame_params params = { .color_format = s->color.format,
                                            .depth_format = s->depth.format,
                                            .depth_reversed = true };
    d.plan = stage_plan(&s->engine, s->context, d.scene, &largest, &ways[way]);
    d.resident = stage_resident(&s->engine, s->context, d.scene, d.plan, NULL);
    for (int i = 0; i < ENGINE_FRAMES; i++)
        d.frame[i] = stage_frame(&s->engine, s->context, d.plan, &params);
    return d;
}

static void close_drawn(struct drawn *d)
{
    for (int i = 0; i < ENGINE_FRAMES; i++) /* the one that compiled their pipelines goes first */
        stp_frame_destroy(&d->frame[i]);
    stp_resident_destroy(&d->resident);
    stp_plan_destroy(&d->plan);
    stp_scene_destroy(&d->scene);
}

static uint32_t random_to(uint32_t *seed, uint32_t count)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) % count;
}

static void one_frame(struct stage *s, struct drawn drawn[SCENES][WAYS], unsigned n, uint32_t *seed)
{
    unsigned slot = n % ENGINE_FRAMES;
    VkCommandBuffer commands = engine_begin(&s->engine, slot);
    stage_clear(commands, s, NULL, 0);
    for (uint32_t pictures = 1 + random_to(seed, 2), i = 0; i < pictures; i++) {
        /* Two pictures of one frame object need two of them: each its own scene. */
        struct drawn *d = &drawn[(random_to(seed, 2) + 2 * i) % SCENES][random_to(seed, WAYS)];
        struct stp_targets targets = stage_targets(s);
        struct stp_camera camera =
            stage_view(d->scene, 1 + random_to(seed, WIDTH), 1 + random_to(seed, HEIGHT),
                       0.01 * random_to(seed, 628));
        targets.x = (int32_t)random_to(seed, 2 * WIDTH) - WIDTH;
        targets.y = (int32_t)random_to(seed, 2 * HEIGHT) - HEIGHT;
        if (stp_frame_record(&s->engine.env, d->frame[slot], d->resident, &camera, &targets,
                             commands))
            fail_msg("frame %u: %s", n, s->engine.last);
    }
    engine_submit(&s->engine, slot);
}

static void resize(struct stage *s, uint32_t *seed)
{
    uint32_t width = 8 + random_to(seed, 90), height = 8 + random_to(seed, 90);
    VkFormat color = s->color.format, depth = s->depth.format;
    engine_finish(&s->engine);
    engine_image_close(&s->engine, &s->color);
    engine_image_close(&s->engine, &s->depth);
    engine_image_open(&s->engine, color, width, height, &s->color);
    engine_image_open(&s->engine, depth, width, height, &s->depth);
}

static void test_storm(void **state)
{
    struct stage s;
    struct drawn drawn[SCENES][WAYS];
    uint32_t seed = 7;
    stage_open(&s, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    for (unsigned i = 0; i < SCENES; i++)
        for (unsigned w = 0; w < WAYS; w++)
            drawn[i][w] = open_drawn(&s, i, w);
    for (unsigned n = 0; n < FRAMES; n++) {
        if (n % 50 == 49)
            resize(&s, &seed);
        if (n % 200 == 199) { /* a scene goes and another comes */
            unsigned i = random_to(&seed, SCENES), w = random_to(&seed, WAYS);
            engine_finish(&s.engine);
            close_drawn(&drawn[i][w]);
            drawn[i][w] = open_drawn(&s, i, w);
        }
        one_frame(&s, drawn, n, &seed);
    }
    engine_finish(&s.engine);
    for (unsigned i = 0; i < SCENES; i++)
        for (unsigned w = 0; w < WAYS; w++)
            close_drawn(&drawn[i][w]);
    stage_close(&s);
}

/* Each thread records into a command buffer of its own, with a frame of its own. */
struct recording {
    struct stage *s;
    struct drawn *d;
    unsigned slot;
    VkCommandBuffer commands;
    enum stp_result result;
};

static void *record(void *user)
{
    struct recording *r = user;
    struct stp_targets targets = stage_targets(r->s);
    r->result = stp_frame_record(NULL, r->d->frame[r->slot], r->d->resident, &r->s->camera,
                                 &targets, r->commands);
    return NULL;
}

static void test_two_threads(void **state)
{
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct drawn d = open_drawn(&s, 2, 0);
    s.camera = stage_view(d.scene, WIDTH, HEIGHT, 0.3);
    struct stp_image *expected = stage_offline(&s.engine, d.scene, &s.camera, &ways[0]);
    for (int round = 0; round < 20; round++) {
        struct recording recording[2];
        pthread_t thread[2];
        for (unsigned i = 0; i < 2; i++) {
            recording[i] = (struct recording){ &s, &d, i, engine_begin(&s.engine, i), 0 };
            stage_clear(recording[i].commands, &s, NULL, 0);
            assert_int_equal(pthread_create(&thread[i], NULL, record, &recording[i]), 0);
        }
        for (unsigned i = 0; i < 2; i++) {
            pthread_join(thread[i], NULL);
            assert_int_equal(recording[i].result, STP_OK);
        }
        for (unsigned i = 0; i < 2; i++)
            engine_submit(&s.engine, i);
        float *texels = engine_read(&s.engine, &s.color, 16);
        stage_same(expected, texels, "recorded on a thread");
        free(texels);
    }
    stp_image_destroy(&expected);
    close_drawn(&d);
    stage_close(&s);
}

/* Two contexts in one process, on a device each, know nothing of each other. */
static void test_two_devices(void **state)
{
    struct stage a, b;
    stage_open(&a, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    stage_open(&b, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    struct drawn da = open_drawn(&a, 0, 0), db = open_drawn(&b, 2, 1);
    struct stage *stages[] = { &a, &b };
    struct drawn *drawn[] = { &da, &db };
    for (unsigned i = 0; i < 2; i++) {
        struct stp_targets targets = stage_targets(stages[i]);
        stages[i]->camera = stage_view(drawn[i]->scene, WIDTH, HEIGHT, 1);
        VkCommandBuffer commands = engine_begin(&stages[i]->engine, 0);
        stage_clear(commands, stages[i], NULL, 0);
        assert_int_equal(stp_frame_record(NULL, drawn[i]->frame[0], drawn[i]->resident,
                                          &stages[i]->camera, &targets, commands),
                         STP_OK);
        engine_submit(&stages[i]->engine, 0);
    }
    for (unsigned i = 0; i < 2; i++) {
        struct engine *e = &stages[i]->engine;
        struct stp_image *expected =
            stage_offline(e, drawn[i]->scene, &stages[i]->camera, &ways[i]);
        float *texels = engine_read(e, &stages[i]->color, 16);
        stage_same(expected, texels, "two devices");
        free(texels);
        stp_image_destroy(&expected);
        close_drawn(drawn[i]);
        stage_close(stages[i]);
    }
}

#define COST_TURNS  25
#define COST_POINTS 100000
/* A hundredth of a frame at 60 Hz: what a host does not notice. */
#define COST_MOST (1e3 / 60 / 100)

struct turns {
    double ms[COST_TURNS]; /* ascending */
    unsigned count;
};

static double cpu_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static void add_turn(struct turns *t, double ms)
{
    unsigned at = t->count++;
    for (; at > 0 && t->ms[at - 1] > ms; at--)
        t->ms[at] = t->ms[at - 1];
    t->ms[at] = ms;
}

/* The median time of one look at every splat. */
static double walk_cost(void)
{
    static volatile float splats[COST_POINTS][8];
    struct turns turns = { .count = 0 };
    while (turns.count < COST_TURNS) {
        float sum = 0;
        double before = cpu_ms();
        for (size_t i = 0; i < COST_POINTS; i++)
            sum += splats[i][0];
        add_turn(&turns, cpu_ms() - before);
        assert_true(sum == 0);
    }
    return turns.ms[COST_TURNS / 2];
}

static double recording_cost(struct stage *s, size_t points)
{
    struct stp_scene *scene = stage_ball(&s->engine, points, true, 1, 1);
    struct stp_camera camera = stage_view(scene, WIDTH, HEIGHT, 0);
    struct stp_host_frame_params params = { .color_format = s->color.format };
    struct stp_plan *plan = stage_plan(&s->engine, s->context, scene, &camera, &ways[0]);
    struct stp_resident *resident = stage_resident(&s->engine, s->context, scene, plan, NULL);
    struct stp_frame *frame = stage_frame(&s->engine, s->context, plan, &params);
    struct stp_targets targets = stage_targets(s);
    struct turns turns = { .count = 0 };
    while (turns.count < COST_TURNS) {
        VkCommandBuffer commands = engine_begin(&s->engine, 0);
        stage_clear(commands, s, NULL, 0);
        double before = cpu_ms();
        assert_int_equal(stp_frame_record(NULL, frame, resident, &camera, &targets, commands),
                         STP_OK);
        add_turn(&turns, cpu_ms() - before);
        engine_submit(&s->engine, 0);
    }
    engine_finish(&s->engine);
    stp_frame_destroy(&frame);
    stp_resident_destroy(&resident);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
    return turns.ms[COST_TURNS / 2];
}

/* Recording looks at no splat: else a large scene would add at least what one look at each takes.
 */
static void test_cost(void **state)
{
    struct stage s;
    stage_open(&s, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_D32_SFLOAT, "validation");
    double small = recording_cost(&s, 100), large = recording_cost(&s, COST_POINTS);
    double walk = walk_cost();
    print_message("recorded in %.3f ms, of %d points %.3f ms; a look at each %.3f ms\n", small,
                  COST_POINTS, large, walk);
    assert_true(small < COST_MOST && large < COST_MOST);
    assert_true(large - small < walk);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_storm),
        cmocka_unit_test(test_two_threads),
        cmocka_unit_test(test_two_devices),
        cmocka_unit_test(test_cost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
