#include "clouds.h"

#include <stdio.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "scene/scene.h"

static struct stp_scene *make_scene(bool everything)
{
    struct samples s = sample_surface(on_sphere, 5000, 1);
    float color[5000][3], opacity[5000];
    for (size_t i = 0; i < 5000; i++) {
        color[i][0] = color[i][1] = color[i][2] = (float)i;
        opacity[i] = (float)(i % 7) / 7;
    }
    struct stp_points points = { .count = 5000, .position = (const double(*)[3])s.position };
    struct stp_scene *scene;
    if (everything) {
        points.color = (const float(*)[3])color;
        points.opacity = opacity;
    }
    stp_scene_create(NULL, &scene);
    stp_scene_add_points(NULL, scene, &points, NULL);
    if (everything)
        stp_scene_add_points(NULL, scene, &points, NULL);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    if (everything) {
        scene->splats.group = mem_alloc(scene->splats.count, 1);
        for (size_t i = 0; i < scene->splats.count; i++)
            scene->splats.group[i] = (uint8_t)i;
    }
    samples_release(&s);
    return scene;
}

static const unsigned char *same(const unsigned char *at, const void *expected, size_t size)
{
    assert_memory_equal(at, expected, size);
    return at + size;
}

/* Written out by hand from the format's description, not with the writer's own tables. */
static void check_file(const struct stp_scene *scene, const char *path, bool everything)
{
    struct file_bytes bytes;
    const struct splats *s = &scene->splats;
    assert_int_equal(file_read(NULL, path, &bytes), STP_OK);
    const char *text = (const char *)bytes.data, *end = strstr(text, "end_header\n");
    char header[2000] = "", count[64];
    assert_non_null(end);
    memcpy(header, text, (size_t)(end - text));
    snprintf(count, sizeof count, "\nelement vertex %zu\n", s->count);
    assert_true(strncmp(header, "ply\nformat binary_little_endian 1.0\n", 36) == 0);
    assert_non_null(strstr(header, "\ncomment stipple prepared 1\n"));
    assert_non_null(strstr(header, count));
    assert_non_null(strstr(header, "\nproperty double z\nproperty float nx\n"));
    assert_int_equal(strstr(header, "ushort object") != NULL, everything);
    const unsigned char *at = (const unsigned char *)end + 11;
    for (size_t i = 0; i < s->count; i++) {
        at = same(at, s->position[i], 24);
        at = same(at, s->normal[i], 12);
        at = same(at, &s->radius[i], 4);
        if (everything) {
            at = same(at, s->color[i], 12);
            at = same(at, &s->opacity[i], 4);
        }
        at = same(at, &s->input[i], 4);
        if (everything) {
            at = same(at, &s->object[i], 2);
            at = same(at, &s->group[i], 1);
        }
    }
    assert_ptr_equal(at, bytes.data + bytes.size);
    file_release(&bytes);
}

static void writes_every_array(void **state)
{
    const char path[] = "test_save.ply";
    for (int everything = 0; everything < 2; everything++) {
        struct stp_scene *scene = make_scene(everything);
        assert_int_equal(stp_scene_save(NULL, scene, path), STP_OK);
        check_file(scene, path, everything);
        stp_scene_destroy(&scene);
    }
    unlink(path);
}

static void failures(void **state)
{
    char line[512] = "";
    struct stp_env env = { .log = silent, .user = line };
    struct stp_scene *scene = make_scene(false), *empty;
    assert_int_equal(stp_scene_save(&env, scene, "no/such/folder/a.ply"), STP_ERROR_IO);
    assert_non_null(strstr(line, "no/such/folder/a.ply"));
    assert_int_equal(stp_scene_save(&env, scene, "/dev/full/a.ply"), STP_ERROR_IO);
    stp_scene_create(&env, &empty);
    assert_int_equal(stp_scene_save(&env, empty, "test_save_none.ply"), STP_ERROR_ARGUMENT);
    assert_int_equal(access("test_save_none.ply", F_OK), -1);
    env.user = NULL;
    for (unsigned long n = 1, reached = 1; reached; n++) {
        mem_fail_at(n);
        enum stp_result result = stp_scene_save(&env, scene, "test_save_memory.ply");
        reached = mem_count() >= n;
        mem_fail_at(0);
        assert_int_equal(result, reached ? STP_ERROR_MEMORY : STP_OK);
        assert_int_equal(access("test_save_memory.ply", F_OK), reached ? -1 : 0);
    }
    unlink("test_save_memory.ply");
    stp_scene_destroy(&scene);
    stp_scene_destroy(&empty);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(writes_every_array),
        cmocka_unit_test(failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
