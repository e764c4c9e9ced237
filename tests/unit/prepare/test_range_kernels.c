/* Range images to ellipsoids: places, shapes, sources and weights, and the lists of a view. */
#include "ranges.h"

#include "prepare/axis_lists.h"
#include "prepare/axis_region.h"
#include "reference/range.h"
#include "walks.h"

enum { W = 40, H = 30 };

/* A tilted plane: axes lie in it, one deviation along the ray. */
static void shapes_follow_the_surface(void **state)
{
    struct range range = wall_range(16, 12, 20, 1, 0.03);
    const struct vec3 n = v3_unit(v3(0.4, -0.3, 1)); /* of the plane n.p = 2, frame coordinates */
    for (uint32_t v = 0; v < 12; v++)
        for (uint32_t u = 0; u < 16; u++) {
            struct vec3 d = v3((u + 0.5 - 8) / 20, (v + 0.5 - 6) / 20, 1);
            range.frame->depth[v * 16 + u] = (float)(2 / v3_dot(n, d));
        }
    struct stp_scene *scene = range_scene(&range);
    const struct kernels *k = &scene->volume->kernels;
    assert_int_equal(k->count, 16 * 12);
    for (size_t i = 0; i < k->count; i++) {
        double u = (double)(i % 16) + 0.5 - 8, v = (double)(i / 16) + 0.5 - 6;
        struct vec3 d = v3(u / 20, v / 20, 1);
        double z = 2 / v3_dot(n, d);
        struct vec3 a = v3_loadf(k->axes[i][0]), b = v3_loadf(k->axes[i][1]);
        struct vec3 c = v3_loadf(k->axes[i][2]), world = v3(n.x, -n.y, -n.z);
        close_to(k->place[i][0], u / 20 * z, 1e-6);
        close_to(k->place[i][2], -z, 1e-6);
        close_to(v3_dot(a, world) / v3_length(a), 0, 0.02);
        close_to(v3_dot(b, world) / v3_length(b), 0, 0.02);
        close_to(a.x - u / 20 * -a.z, 0.55 * z / 20, 1e-6); /* what is across the ray */
        close_to(-c.z, 0.03, 1e-7);
        close_to(v3_length(v3_cross(c, v3(d.x, -d.y, -d.z))), 0, 1e-7);
    }
    stp_scene_destroy(&scene);
}

static void deviations_follow_the_sensor(void **state)
{
    struct range_frame f = { .camera = { .fx = 500 }, .sensor = { .sigma = 1.5e-3 } };
    close_to(range_deviation(&f, 2), 6e-3, 1e-12);
    f.sensor =
        (struct range_sensor){ .kind = RANGE_STEREO, .sigma_disparity = 0.5, .baseline = 0.1 };
    /* By the definition: half a pixel of disparity, both ways. */
    double d = 500 * 0.1 / 2;
    close_to(range_deviation(&f, 2), 0.5 * (50 / (d - 0.5) - 50 / (d + 0.5)), 1e-4);
    f.sensor = (struct range_sensor){ .kind = RANGE_CONSTANT, .sigma = 0.25 };
    close_to(range_deviation(&f, 2), 0.25, 0);
}

/* An edge is not a slope: beyond it nothing is stretched. */
static void edges_are_not_bridged(void **state)
{
    struct range range = wall_range(16, 4, 20, 1, 0.01);
    for (int i = 0; i < 64; i++)
        range.frame->depth[i] = i % 16 < 8 ? 1 : 3;
    struct stp_scene *scene = range_scene(&range);
    const struct kernels *k = &scene->volume->kernels;
    for (size_t i = 0; i < k->count; i++)
        close_to((double)k->axes[i][0][2], 0, 1e-9);
    stp_scene_destroy(&scene);
}

/* Two frames of one wall: each knows the other, by inverse variance; a third sees something nearer.
 */
static struct stp_scene *three_frames(bool by_views)
{
    struct range one = wall_range(16, 16, 30, 2, 0.02), range = { .count = 3, .uncertainty = 1 };
    range.frame = mem_zalloc(3, sizeof *range.frame);
    range.by_views = by_views;
    for (int i = 0; i < 3; i++) {
        struct range_camera camera = one.frame->camera;
        camera.to_world[3] = 0.05 * i;
        range_frame_make(&range.frame[i], &camera, 16, 16, i == 1 ? 0.04 : 0.02);
        for (int n = 0; n < 256; n++) {
            range.frame[i].depth[n] = i == 2 ? 1.1f : 2;
            range.frame[i].color[n][i] = 1;
        }
    }
    range_release(&one);
    return range_scene(&range);
}

static void frames_that_agree_share_the_surface(void **state)
{
    struct stp_scene *scene = three_frames(false);
    const struct kernels *k = &scene->volume->kernels;
    size_t pairs = 0;
    for (size_t i = 0; i < k->count; i++) {
        const struct kernel_source *s = k->source + k->source_first[i];
        size_t count = k->source_first[i + 1] - k->source_first[i], frame = i / 256;
        assert_int_equal(s[0].frame, frame);
        close_to((double)s[0].weight, 1, 0);
        assert_true(count <= (frame == 2 ? 1 : 2));
        if (count < 2)
            continue;
        pairs++;
        assert_int_equal(s[1].frame, 1 - frame);
        close_to((double)s[1].weight, frame == 0 ? 0.25 : 4, 1e-5);
    }
    assert_true(pairs > 400);
    assert_null(k->source_color);
    stp_scene_destroy(&scene);
}

/* Weights of one surface add up to one; the better frame, and the nearer view, weigh more. */
static void weights_of_a_view(void **state)
{
    struct stp_scene *scene = three_frames(false);
    const struct kernels *k = &scene->volume->kernels;
    struct stp_camera camera = plain_camera(16, 16, 30);
    struct range_view view = range_view_of(&camera);
    size_t middle = 8 * 16 + 8;
    double near = range_tau(scene->volume, &view, middle) / (double)k->tau[middle];
    double far = range_tau(scene->volume, &view, 256 + middle) / (double)k->tau[256 + middle];
    assert_true(near > 0.8 && near < 1 && far < 0.2);
    close_to(near + far, 1, 0.01);
    look_at(&camera, v3(0.05, 0, 0), v3(0.05, 0, -1)); /* where the worse frame was */
    view = range_view_of(&camera);
    assert_true(range_tau(scene->volume, &view, middle) / (double)k->tau[middle] < near);
    stp_scene_destroy(&scene);
}

/* At a source's own eye it decides the colour; between two, both. */
static void colours_by_views(void **state)
{
    struct stp_scene *scene = three_frames(true);
    struct stp_camera camera = plain_camera(16, 16, 30);
    size_t i = 8 * 16 + 8;
    double share[3];
    for (int n = 0; n < 3; n++) {
        double color[3];
        look_at(&camera, v3(0.4 * n - 0.4, 0, 0), v3(0.4 * n - 0.4, 0, -1));
        struct range_view view = range_view_of(&camera);
        range_color(scene->volume, &view, i, color);
        close_to(color[0] + color[1] + color[2], 1, 1e-6);
        share[n] = color[1];
    }
    assert_true(share[0] < share[2] && share[0] > 0.05);
    camera = plain_camera(16, 16, 30);
    struct range_view view = range_view_of(&camera);
    double color[3];
    range_color(scene->volume, &view, i, color);
    assert_true(color[0] > 0.8);
    stp_scene_destroy(&scene);
}

/* Which pixels an ellipsoid has a fragment on, by the lists and by the reference, in every hard
 * view; its rectangle holds them all. */
static void lists_and_reference_agree(void **state)
{
    size_t hits = 0;
    for (int v = 0; v < VIEWS; v++) {
        struct range range = random_range(40 + (uint32_t)v, 2, 5, v % 2 ? 0.3 : 0.01);
        struct stp_scene *scene = range_scene(&range);
        struct stp_camera camera = hard_view(v, W, H);
        struct view view = { .scene = scene, .width = W, .height = H, .grid = 1 };
        struct axis_view axis = axis_view(scene, &camera);
        struct medium medium;
        eye_init(&view.eye, &camera, scene->splats.origin);
        assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
        for (uint32_t k = 0; k < scene->volume->kernels.count; k++) {
            struct axis_kernel kernel;
            struct axis_rectangle r;
            double tau = axis_tau(&axis, k);
            axis_kernel(&axis, k, &kernel);
            close_to(tau / medium.tau[k], 1, 1e-9);
            bool seen = axis_pixels(&kernel, &r);
            for (uint32_t p = 0; p < W * H; p += 3) {
                uint32_t x = p % W, y = p / W;
                struct ray ray = eye_ray(&view.eye, x + 0.5, y + 0.5);
                struct medium_fragment f;
                bool hit = ellipsoid_hit(&medium, k, medium_centre(&medium, k), tau, &ray, &f);
                if (hit)
                    assert_true(seen && x >= r.x0 && x <= r.x1 && y >= r.y0 && y <= r.y1);
                assert_int_equal(hit, axis_hits(&kernel, tau, x + 0.5, y + 0.5));
                hits += hit;
            }
        }
        medium_release(&medium);
        stp_scene_destroy(&scene);
    }
    assert_true(hits > 1000);
}

/* Far to near along the axis, or by distance; no ellipsoid twice in a list. */
static void lists_are_in_order(void **state)
{
    struct range range = random_range(7, 3, 10, 0.05);
    struct stp_scene *scene = range_scene(&range);
    size_t count = scene->volume->kernels.count;
    uint8_t *seen = malloc(count);
    for (int v = 0; v < VIEWS; v++)
        for (int merge = STP_AXIS_BLEND; merge <= STP_AXIS_SORT; merge++) {
            struct stp_camera camera = hard_view(v, W, H);
            struct axis_lists lists;
            assert_int_equal(
                lists_of_view(NULL, scene, &camera, (enum stp_axis_merge)merge, 0.85, &lists),
                STP_OK);
            for (unsigned w = 0; w < lists.walk_count; w++) {
                const struct axis_walk *walk = &lists.walk[w];
                double last = INFINITY;
                memset(seen, 0, count);
                for (uint32_t i = walk->first; i < walk->first + walk->count; i++) {
                    const double *p = scene->volume->kernels.place[lists.order[i]];
                    struct vec3 c = m4_point(camera.world_to_camera, v3_load(p));
                    double far = merge != STP_AXIS_SORT ? p[walk->axis] * (walk->backwards ? -1 : 1)
                                 : camera.orthographic  ? -c.z
                                                        : v3_dot(c, c);
                    assert_true(far <= last && !seen[lists.order[i]]++);
                    last = far;
                }
            }
            axis_lists_release(&lists);
        }
    free(seen);
    stp_scene_destroy(&scene);
}

/* The same bits on one thread and many; every allocation fails once, and nothing has changed. */
static void threads_and_failures(void **state)
{
    struct range range = random_range(21, 3, 20, 0.05), again = random_range(21, 3, 20, 0.05);
    range.by_views = again.by_views = true;
    struct stp_env one = { .threads = 1 };
    struct stp_scene *scene = NULL, *other = range_scene(&again);
    assert_int_equal(stp_scene_create(&one, &scene), STP_OK);
    assert_int_equal(scene_add_range(&one, scene, &range), STP_OK);
    for (unsigned long n = 1;; n++) {
        mem_fail_at(n);
        enum stp_result result = prepare_range(&one, scene, NULL);
        unsigned long used = mem_count();
        mem_fail_at(0);
        if (result == STP_OK) {
            assert_true(used < n && n > 8);
            break;
        }
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_true(scene->volume->kernels.count == 0 && !scene->prepared);
    }
    const struct kernels *a = &scene->volume->kernels, *b = &other->volume->kernels;
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->place, b->place, a->count * sizeof *a->place);
    assert_memory_equal(a->axes, b->axes, a->count * sizeof *a->axes);
    assert_memory_equal(a->source_first, b->source_first, (a->count + 1) * 4);
    assert_memory_equal(a->source_color, b->source_color,
                        a->source_first[a->count] * sizeof *a->source_color);
    stp_scene_destroy(&scene);
    stp_scene_destroy(&other);
}

static void what_has_nothing_to_draw(void **state)
{
    struct range range = wall_range(4, 4, 10, 0, 0.1);
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(scene_add_range(NULL, scene, &range), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_ERROR_NO_POINTS);
    stp_scene_destroy(&scene);
    const double box[6] = { -1, -1, -9, 1, 1, -8 };
    const struct stp_prepare_params params = { .clip_box = box };
    range = wall_range(4, 4, 10, 2, 0.1);
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(scene_add_range(NULL, scene, &range), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, &params), STP_ERROR_NO_POINTS);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_follow_the_surface),
        cmocka_unit_test(deviations_follow_the_sensor),
        cmocka_unit_test(edges_are_not_bridged),
        cmocka_unit_test(frames_that_agree_share_the_surface),
        cmocka_unit_test(weights_of_a_view),
        cmocka_unit_test(colours_by_views),
        cmocka_unit_test(lists_and_reference_agree),
        cmocka_unit_test(lists_are_in_order),
        cmocka_unit_test(threads_and_failures),
        cmocka_unit_test(what_has_nothing_to_draw),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
