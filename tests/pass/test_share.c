/* One picture by several processes, which are threads here: the same bits as by one, whatever it
 * shows and however it is cut; and one that fails ends all. */
#include "device.h"

#include <pthread.h>
#include <stipple/machines.h>
#include <unistd.h>

#include "base/memory.h"
#include "scene/scene.h"

#define PROCESSES 4
#define WIDTH     93
#define HEIGHT    61
#define POINTS    700

/* Machines that share memory. */
struct room {
    pthread_barrier_t barrier;
    unsigned count;
    enum stp_result result[PROCESSES];
    int64_t *values[PROCESSES];
    unsigned reductions;
};

struct place {
    struct room *room;
    unsigned rank;
};

static enum stp_result agree(void *user, enum stp_result mine)
{
    struct place *place = user;
    enum stp_result worst = STP_OK;
    place->room->result[place->rank] = mine;
    pthread_barrier_wait(&place->room->barrier);
    for (unsigned i = 0; i < place->room->count; i++)
        if (place->room->result[i] > worst)
            worst = place->room->result[i];
    pthread_barrier_wait(&place->room->barrier);
    return worst;
}

/* Where only the root gets the result the others' values are spoilt, as the contract allows. */
static void reduce(void *user, enum stp_reduction reduction, int64_t *values, size_t count,
                   bool to_all)
{
    struct place *place = user;
    struct room *room = place->room;
    room->values[place->rank] = values;
    pthread_barrier_wait(&room->barrier);
    for (size_t i = 0; place->rank == 0 && i < count; i++) {
        for (unsigned r = 1; r < room->count; r++) {
            int64_t other = room->values[r][i];
            if (reduction == STP_REDUCE_SUM)
                values[i] += other;
            else if (other < values[i])
                values[i] = other;
        }
        for (unsigned r = 1; r < room->count; r++)
            room->values[r][i] = to_all ? values[i] : INT64_C(0x5a5a5a5a5a5a5a5a);
    }
    if (place->rank == 0)
        room->reductions++;
    pthread_barrier_wait(&room->barrier);
}

struct wish {
    const char *what;
    bool colors, normals, two_objects;
    unsigned samples, aovs, mask_features;
    uint64_t memory_limit;
    bool background;
    double near_depth; /* 0: as framed */
};

static void add(struct stp_scene *scene, const struct wish *wish, unsigned object, uint32_t seed)
{
    double position[POINTS][3];
    float color[POINTS][3], normal[POINTS][3];
    for (unsigned i = 0; i < POINTS; i++) {
        double z = 1 - (2 * i + 1.0) / POINTS, ring = sqrt(1 - z * z), turn = i * 2.399963;
        struct vec3 p = v3(ring * cos(turn), ring * sin(turn), z);
        for (int k = 0; k < 3; k++)
            color[i][k] = (float)(3 * uniform(&seed));
        memcpy(position[i], (double[3]){ p.x + 0.4 * object, p.y, p.z }, sizeof *position);
        /* Opposed neighbours: where their sum vanishes, the nearest one's normal stands. */
        float sign = i % 5 ? 1 : -1;
        memcpy(normal[i], (float[3]){ sign * (float)p.x, sign * (float)p.y, sign * (float)p.z },
               sizeof *normal);
    }
    struct stp_points points = { .count = POINTS,
                                 .position = position,
                                 .normal = wish->normals ? normal : NULL,
                                 .color = wish->colors ? color : NULL };
    struct stp_material material = { .1f, .7f, .2f, object ? 8 : 32, { .8f, .5f, .2f }, 1 };
    struct stp_object_params params = { .material = &material, .epsilon = object ? 0.3 : 0 };
    assert_int_equal(stp_scene_add_points(NULL, scene, &points, &params), STP_OK);
}

static struct stp_scene *make(const struct wish *wish)
{
    struct stp_scene *scene = NULL;
    struct stp_prepare_params prepare = { 0 };
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    for (unsigned object = 0; object < (wish->two_objects ? 2 : 1); object++)
        add(scene, wish, object, 7 + object);
    assert_int_equal(stp_scene_prepare(NULL, scene, &prepare), STP_OK);
    return scene;
}

static struct stp_camera framed(const struct stp_scene *scene, const struct wish *wish)
{
    struct stp_camera camera;
    struct stp_frame_params params = {
        .azimuth = 0.4, .elevation = 0.3, .width = WIDTH, .height = HEIGHT
    };
    assert_int_equal(stp_camera_frame(NULL, scene, &params, &camera), STP_OK);
    if (wish->near_depth > 0)
        camera.near_depth = wish->near_depth;
    return camera;
}

static struct stp_render_params params_of(const struct wish *wish)
{
    static const float background[] = { 0.2f, 0.4f, 0.6f, 0.5f };
    return (struct stp_render_params){ .method = STP_METHOD_TWO_PASS,
                                       .path = STP_PATH_COMPUTE,
                                       .samples = wish->samples,
                                       .aovs = wish->aovs,
                                       .mask_features = wish->mask_features,
                                       .memory_limit = wish->memory_limit,
                                       .background = wish->background ? background : NULL };
}

struct job {
    const struct wish *wish;
    struct place place;
    struct device device;
    unsigned repeat;
    bool fails; /* this one has no device */
    struct stp_image *image;
    struct stp_render_stats stats;
    enum stp_result result;
};

static enum stp_result run(struct job *job, struct stp_scene *scene)
{
    struct stp_machines machines = {
        .rank = job->place.rank, .count = job->place.room->count, &job->place, agree, reduce
    };
    struct stp_render_params params = params_of(job->wish);
    struct stp_camera camera = framed(scene, job->wish);
    struct stp_plan *plan = NULL;
    assert_int_equal(stp_scene_share(NULL, scene, machines.rank, machines.count), STP_OK);
    assert_int_equal(device_plan(&job->device, scene, &camera, &params, &plan), STP_OK);
    enum stp_result result =
        stp_render_share(&job->device.env, job->fails ? NULL : job->device.context, scene, plan,
                         &machines, job->repeat, &job->image, &job->stats);
    stp_plan_destroy(&plan);
    return result;
}

static void *run_job(void *user)
{
    struct job *job = user;
    struct stp_scene *scene = make(job->wish);
    job->result = run(job, scene);
    stp_scene_destroy(&scene);
    return NULL;
}

/* Devices are opened before and closed after, on the test's own thread. */
static void run_all(struct device *devices, struct room *room, struct job *jobs, unsigned count)
{
    pthread_t thread[PROCESSES];
    *room = (struct room){ .count = count };
    pthread_barrier_init(&room->barrier, NULL, count);
    for (unsigned i = 0; i < count; i++) {
        jobs[i].place = (struct place){ room, i };
        jobs[i].device = devices[i];
        jobs[i].device.env.user = &jobs[i].device;
        jobs[i].device.lines = 0;
        assert_int_equal(pthread_create(&thread[i], NULL, run_job, &jobs[i]), 0);
    }
    for (unsigned i = 0; i < count; i++)
        pthread_join(thread[i], NULL);
    pthread_barrier_destroy(&room->barrier);
}

static const struct wish wishes[] = {
    { .what = "plain", .normals = true },
    { .what = "colours, every AOV",
      .normals = true,
      .colors = true,
      .aovs = STP_AOV_ALBEDO | STP_AOV_POSITION | STP_AOV_WEIGHT | STP_AOV_FRAGMENTS |
              STP_AOV_COVERAGE | STP_AOV_ID | STP_AOV_LAYERS },
    { .what = "two objects of two epsilons", .normals = true, .two_objects = true },
    { .what = "four samples and ids",
      .normals = true,
      .colors = true,
      .two_objects = true,
      .samples = 4,
      .aovs = STP_AOV_ID | STP_AOV_POSITION },
    { .what = "tiles", .normals = true, .colors = true, .memory_limit = 300000 },
    { .what = "no 64-bit atomics",
      .normals = true,
      .colors = true,
      .mask_features = STP_FEATURE_INT64_ATOMICS },
    { .what = "normals estimated, a background", .background = true },
    { .what = "cut by the near plane", .normals = true, .near_depth = 4.0, .aovs = STP_AOV_ID },
};
#define WISHES (sizeof wishes / sizeof *wishes)

static struct device devices[PROCESSES];

/* Ids too: all processes have the same input. */
static void expect_alike(const struct stp_image *image, const struct stp_image *whole,
                         const char *what)
{
    assert_non_null(image);
    expect_same_bits(image, whole, what);
    const struct stp_channel *a = stp_image_find(image, "id"), *b = stp_image_find(whole, "id");
    assert_int_equal(!a, !b);
    if (a)
        assert_memory_equal(a->data.u, b->data.u, sizeof(uint32_t) * WIDTH * HEIGHT);
}

static void test_same_bits(void **state)
{
    for (unsigned w = 0; w < WISHES; w++) {
        const struct wish *wish = &wishes[w];
        struct stp_scene *scene = make(wish);
        struct stp_camera camera = framed(scene, wish);
        struct stp_render_params params = params_of(wish);
        struct stp_image *whole = device_render(&devices[0], scene, &camera, &params);
        stp_scene_destroy(&scene);
        for (unsigned count = w == 1 ? 1 : 3; count <= (w == 1 ? PROCESSES : 3); count++) {
            struct job jobs[PROCESSES] = { 0 };
            struct room room;
            for (unsigned i = 0; i < count; i++)
                jobs[i].wish = wish;
            run_all(devices, &room, jobs, count);
            for (unsigned i = 0; i < count; i++) {
                if (jobs[i].result != STP_OK || jobs[i].device.lines)
                    fail_msg("%s, %u of %u: %s: %s", wish->what, i, count,
                             stp_result_text(jobs[i].result), jobs[i].device.last);
                assert_true(i == 0 || !jobs[i].image);
            }
            expect_alike(jobs[0].image, whole, wish->what);
            assert_true(room.reductions >= 3);
            stp_image_destroy(&jobs[0].image);
        }
        stp_image_destroy(&whole);
    }
}

static void test_timed(void **state)
{
    struct job jobs[2] = { { .wish = &wishes[0], .repeat = 2 },
                           { .wish = &wishes[0], .repeat = 2 } };
    struct room room;
    run_all(devices, &room, jobs, 2);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(jobs[i].result, STP_OK);
        assert_int_equal(jobs[i].stats.frames, 2);
    }
    stp_image_destroy(&jobs[0].image);
}

/* Whoever fails, all return its result, and one line is logged. */
static void test_one_fails(void **state)
{
    for (unsigned failing = 0; failing < 3; failing++) {
        struct job jobs[3] = { { .wish = &wishes[0] },
                               { .wish = &wishes[0] },
                               { .wish = &wishes[0] } };
        struct room room;
        jobs[failing].fails = true;
        run_all(devices, &room, jobs, 3);
        for (unsigned i = 0; i < 3; i++) {
            assert_int_equal(jobs[i].result, STP_ERROR_ARGUMENT);
            assert_int_equal(jobs[i].device.lines, i == failing);
            assert_null(jobs[i].image);
        }
    }
}

static void test_different_pictures(void **state)
{
    struct job jobs[2] = { { .wish = &wishes[0] }, { .wish = &wishes[1] } };
    struct room room;
    run_all(devices, &room, jobs, 2);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(jobs[i].result, STP_ERROR_ARGUMENT);
        assert_int_equal(jobs[i].device.lines, i == 0);
        assert_null(jobs[i].image);
    }
}

static void test_refused(void **state)
{
    struct stp_scene *scene = make(&wishes[0]);
    struct stp_camera camera = framed(scene, &wishes[0]), untouched;
    struct stp_plan *plan = NULL;
    struct stp_image *image = NULL;
    struct device *device = &devices[0];
    struct stp_env *env = &device->env;
    struct stp_render_params params = { .method = STP_METHOD_EXACT };
    assert_int_equal(stp_scene_share(env, scene, 2, 2), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_share(env, scene, 0, POINTS + 1), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_share(env, scene, 1, 2), STP_OK);
    assert_int_equal(stp_scene_share(env, scene, 1, 2), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_save(env, scene, "never.ply"), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_camera_frame(NULL, scene, NULL, &untouched), STP_ERROR_ARGUMENT);
    assert_int_equal(device_plan(device, scene, &camera, &params, &plan), STP_ERROR_ARGUMENT);
    params.method = STP_METHOD_AUTO;
    params.path = STP_PATH_RASTER;
    assert_int_equal(device_plan(device, scene, &camera, &params, &plan), STP_ERROR_ARGUMENT);
    params.path = STP_PATH_AUTO;
    assert_int_equal(device_plan(device, scene, &camera, &params, &plan), STP_OK);
    assert_int_equal(stp_render(env, device->context, scene, plan, 0, &image, NULL),
                     STP_ERROR_ARGUMENT);
    assert_null(image);
    stp_plan_destroy(&plan);
    stp_scene_destroy(&scene);
}

static int open_devices(void **state)
{
    for (unsigned i = 0; i < PROCESSES; i++)
        device_open(&devices[i], 0);
    return 0;
}

static int close_devices(void **state)
{
    for (unsigned i = 0; i < PROCESSES; i++)
        device_close(&devices[i]);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits), cmocka_unit_test(test_timed),
        cmocka_unit_test(test_one_fails), cmocka_unit_test(test_different_pictures),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, open_devices, close_devices);
}
