#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include <stipple/image.h>

#include "../log_book.h"
#include "base/memory.h"

static void planes_are_zeroed_and_found_by_name(void **state)
{
    struct stp_image *image = NULL;
    struct stp_channel *r, *id;
    assert_int_equal(stp_image_create(NULL, 3, 2, &image), STP_OK);
    assert_int_equal(stp_image_add(NULL, image, "R", STP_CHANNEL_FLOAT, &r), STP_OK);
    r->data.f[5] = 7;
    assert_int_equal(stp_image_add(NULL, image, "id", STP_CHANNEL_UINT, &id), STP_OK);
    assert_int_equal(image->channel_count, 2);
    assert_int_equal(id->type, STP_CHANNEL_UINT);
    assert_false(id->half);
    for (int i = 0; i < 6; i++)
        assert_int_equal(id->data.u[i], 0);
    assert_ptr_equal(stp_image_find(image, "id"), id);
    assert_true(stp_image_find(image, "R")->data.f[5] == 7); /* kept across an add */
    assert_null(stp_image_find(image, "i"));
    assert_null(stp_image_find(image, "idx"));
    assert_false(image->has_camera);
    stp_image_destroy(&image);
    assert_null(image);
    stp_image_destroy(&image);
    stp_image_destroy(NULL);
}

static void what_is_out_of_range_leaves_outputs_alone(void **state)
{
    struct stp_image *image = NULL;
    struct stp_channel *channel = NULL;
    assert_int_equal(stp_image_create(NULL, 0, 2, &image), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_image_create(NULL, 2, 0, &image), STP_ERROR_ARGUMENT);
    assert_null(image);
    assert_int_equal(stp_image_create(NULL, 1, 1, &image), STP_OK);
    char name[40];
    memset(name, 'a', sizeof name);
    name[32] = '\0';
    assert_int_equal(stp_image_add(NULL, image, name, STP_CHANNEL_FLOAT, &channel),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(stp_image_add(NULL, image, "", STP_CHANNEL_FLOAT, &channel),
                     STP_ERROR_ARGUMENT);
    assert_null(channel);
    name[31] = '\0'; /* the longest there is */
    assert_int_equal(stp_image_add(NULL, image, name, STP_CHANNEL_FLOAT, &channel), STP_OK);
    assert_string_equal(channel->name, name);
    channel = NULL;
    assert_int_equal(stp_image_add(NULL, image, name, STP_CHANNEL_UINT, &channel),
                     STP_ERROR_ARGUMENT);
    assert_null(channel);
    assert_int_equal(image->channel_count, 1);
    stp_image_destroy(&image);
}

static void a_size_beyond_memory_is_said(void **state)
{
    struct stp_image *image = NULL;
    struct stp_channel *channel = NULL;
    assert_int_equal(stp_image_create(NULL, UINT32_MAX, UINT32_MAX, &image), STP_OK);
    assert_int_equal(stp_image_add(NULL, image, "R", STP_CHANNEL_FLOAT, &channel),
                     STP_ERROR_MEMORY);
    assert_int_equal(image->channel_count, 0);
    assert_null(channel);
    stp_image_destroy(&image);
}

static enum stp_result make(struct stp_image **image)
{
    struct stp_channel *channel;
    enum stp_result result = stp_image_create(NULL, 4, 4, image);
    if (result == STP_OK)
        result = stp_image_add(NULL, *image, "R", STP_CHANNEL_FLOAT, &channel);
    if (result == STP_OK)
        result = stp_image_add(NULL, *image, "G", STP_CHANNEL_FLOAT, &channel);
    return result;
}

static void every_allocation_may_fail(void **state)
{
    for (unsigned long n = 1;; n++) {
        struct stp_image *image = NULL;
        mem_fail_at(n);
        enum stp_result result = make(&image);
        mem_fail_at(0);
        if (result == STP_OK)
            assert_true(n == 6); /* one for the picture, two a plane */
        else
            assert_int_equal(result, STP_ERROR_MEMORY);
        stp_image_destroy(&image);
        if (result == STP_OK)
            return;
    }
}

/* Each failure says one line to the caller's log. */
static void failures_are_logged(void **state)
{
    struct log_book book;
    struct stp_env env = logged_env(&book, 1);
    struct stp_image *image = NULL;
    struct stp_channel *channel = NULL;
    assert_int_equal(stp_image_create(&env, 0, 2, &image), STP_ERROR_ARGUMENT);
    assert_int_equal(book.errors, 1);
    assert_int_equal(stp_image_create(&env, 1, 1, &image), STP_OK);
    assert_int_equal(stp_image_add(&env, image, "", STP_CHANNEL_FLOAT, &channel),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(book.errors, 2);
    mem_fail_at(1);
    assert_int_equal(stp_image_add(&env, image, "R", STP_CHANNEL_FLOAT, &channel),
                     STP_ERROR_MEMORY);
    mem_fail_at(0);
    assert_int_equal(book.errors, 3);
    assert_null(channel);
    stp_image_destroy(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(failures_are_logged),
        cmocka_unit_test(planes_are_zeroed_and_found_by_name),
        cmocka_unit_test(what_is_out_of_range_leaves_outputs_alone),
        cmocka_unit_test(a_size_beyond_memory_is_said),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
