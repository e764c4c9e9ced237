/* Damaged files by the thousand, the same ones every time: flipped bits, cuts, splices, and header
 * numbers replaced by hostile ones. Nothing may crash, hang, or hold more points than bytes. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support.h"

#define ROUNDS 6000 /* per seed */

static const char *const seeds[] = {
    ("ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty double y\n"
     "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
     "property float intensity\nelement face 1\nproperty list uchar int vertex_indices\n"
     "end_header\n1 2 3 4 5 6 7\n-1e5 .5 nan 0 255 3 8\n1 1 1 1 1 1 1\n3 0 1 2\n"),
    ("ply\nformat ascii 1.0\nelement a 2\nproperty list uchar int v\nelement vertex 2\n"
     "property list int float w\nproperty int x\nproperty int y\nproperty int z\nend_header\n"
     "2 1 1\n0\n1 0.5 1 2 3\n2 7 7 4 5 6\n"),
    "1 2 3 0 0 1\n4 5 6 0.6 0.8 0\n7 8 9 1 0 0\n",
    "3\n//X,Y,Z,R,G,B,Label\n1,2,3,255,0,9,1\n4,5,6,1,2,3,2\n7,8,9,4,5,6,3\n",
    "NCOFF\n2 1 0\n1 2 3 0 0 1 255 255 0 255\n4 5 6 0 1 0 0 0 9 255\n3 0 1 0\n",
    ("# .PCD v.7\nVERSION .7\nFIELDS x y z rgb w\nSIZE 4 4 8 4 2\nTYPE F F F F U\nCOUNT 1 1 1 1 2\n"
     "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3 4278190335 5 6\n7 8 nan 1e-38 9 0\n"),
    "v 1 2 3 0.5 0.5 0.5\nv 4 5 6 1 1 1\nvn 0 0 1\nvn 1 0 0\nf 1//1 2//2 -1//-1\n",
};

static void make_binary(struct buffer *b, const char *format, bool reversed)
{
    put_text(b,
             "ply\nformat %s 1.0\nelement pre 2\nproperty list uchar short l\nelement vertex 3\n"
             "property float x\nproperty double y\nproperty short z\nproperty uchar red\n"
             "property uchar green\nproperty uchar blue\nproperty float intensity\n"
             "%send_header\n",
             format, reversed ? "" : "property list int uchar m\n");
    put_bytes(b, "\1\0\0\2\0\0\0\0", 8);
    for (int i = 0; i < 3; i++) {
        float x = 1.5f;
        double y = -2.25;
        put_bytes(b, &x, 4);
        put_bytes(b, &y, 8);
        put_bytes(b, "\1\2abc", 5);
        put_bytes(b, &x, 4);
        if (!reversed)
            put_bytes(b, "\2\0\0\0zz", 6);
    }
}

static void flip_bits(struct buffer *b, uint64_t *random)
{
    size_t flips = 1 + next_random(random) % 8;
    for (size_t i = 0; i < flips && b->size; i++)
        b->data[next_random(random) % b->size] ^= (unsigned char)(1u << next_random(random) % 8);
}

static void set_bytes(struct buffer *b, uint64_t *random)
{
    static const unsigned char values[] = { 0, 0xff, '\n', '\r', ' ', '-', '9', '.', 0x7f, 0x80 };
    size_t count = 1 + next_random(random) % 4;
    for (size_t i = 0; i < count && b->size; i++)
        b->data[next_random(random) % b->size] = values[next_random(random) % sizeof values];
}

/* A part of one file in the place of a part of another. */
static void splice(struct buffer *b, const struct buffer *other, uint64_t *random)
{
    struct buffer out = { 0 };
    size_t keep = next_random(random) % (b->size + 1), from = next_random(random) % other->size;
    size_t length = next_random(random) % (other->size - from + 1);
    size_t skip = keep + next_random(random) % (b->size - keep + 1);
    put_bytes(&out, b->data, keep);
    put_bytes(&out, other->data + from, length);
    put_bytes(&out, b->data + skip, b->size - skip);
    drop(b);
    *b = out;
}

/* A number of the file becomes one that hurts. */
static void lie(struct buffer *b, uint64_t *random)
{
    static const char *const numbers[] = { "0",     "-1", "4294967296", "18446744073709551615",
                                           "1e308", "99", "2147483647", "4611686018427387905",
                                           "nan" };
    size_t digits[256], count = 0;
    for (size_t i = 0; i < b->size && count < 256; i++)
        if (b->data[i] >= '0' && b->data[i] <= '9')
            digits[count++] = i;
    if (count == 0)
        return;
    size_t at = digits[next_random(random) % count];
    const char *number = numbers[next_random(random) % 9];
    struct buffer out = { 0 };
    put_bytes(&out, b->data, at);
    put_bytes(&out, number, strlen(number));
    put_bytes(&out, b->data + at + 1, b->size - at - 1);
    drop(b);
    *b = out;
}

static void mutate(struct buffer *b, const struct buffer *other, uint64_t *random)
{
    size_t steps = 1 + next_random(random) % 3;
    for (size_t i = 0; i < steps; i++)
        switch (next_random(random) % 5) {
        case 0:
            flip_bits(b, random);
            break;
        case 1:
            set_bytes(b, random);
            break;
        case 2:
            b->size = next_random(random) % (b->size + 1);
            break;
        case 3:
            splice(b, other, random);
            break;
        default:
            lie(b, random);
        }
}

static void read_mutant(const struct buffer *b, uint64_t *random)
{
    static const char *const names[] = { NULL, "intensity", "class", "x", "height" };
    struct load_options options = { .color_by = names[next_random(random) % 5],
                                    .transfer = (enum stp_transfer)(next_random(random) % 3) };
    struct cloud cloud;
    struct lines lines;
    enum stp_result result = read_buffer(b, &options, 1, &cloud, &lines);
    if (result != STP_OK) {
        assert_true(result == STP_ERROR_FORMAT || result == STP_ERROR_ARGUMENT);
        return;
    }
    assert_in_range(cloud.count, 0, b->size);
    assert_true(memchr(cloud.format, 0, sizeof cloud.format) != NULL);
    cloud_release(&cloud);
}

static void test_mutations(void **state)
{
    enum { TEXTS = sizeof seeds / sizeof *seeds, ALL = TEXTS + 2 };
    struct buffer seed[ALL] = { 0 };
    uint64_t random = 0x9e3779b97f4a7c15u;
    for (int i = 0; i < TEXTS; i++)
        put_bytes(&seed[i], seeds[i], strlen(seeds[i]));
    make_binary(&seed[TEXTS], "binary_little_endian", false);
    make_binary(&seed[TEXTS + 1], "binary_big_endian", true);
    alarm(100); /* a hang is a failure */
    for (int i = 0; i < ALL; i++) {
        read_mutant(&seed[i], &random);
        for (int round = 0; round < ROUNDS; round++) {
            struct buffer b = { 0 };
            put_bytes(&b, seed[i].data, seed[i].size);
            mutate(&b, &seed[next_random(&random) % ALL], &random);
            read_mutant(&b, &random);
            drop(&b);
        }
    }
    for (int i = 0; i < ALL; i++)
        drop(&seed[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_mutations) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
