/* Files that appear whole, with the rights of any new file, and without the process's mask being
 * touched: another thread's files would get other rights meanwhile. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/thread.h"

static unsigned masks_set;

/* In the place of the C library's, for the whole program. */
mode_t umask(mode_t mask)
{
    masks_set++;
    return (mode_t)syscall(SYS_umask, mask);
}

static void in_folder(char *folder, const char *name, char *path, size_t size)
{
    assert_true(snprintf(path, size, "%s/%s", folder, name) < (int)size);
}

static unsigned count_files(const char *folder)
{
    unsigned count = 0;
    DIR *d = opendir(folder);
    assert_non_null(d);
    for (const struct dirent *e; (e = readdir(d));)
        count += e->d_name[0] != '.';
    closedir(d);
    return count;
}

static void make_folder(char *folder)
{
    strcpy(folder, "/tmp/stipple_file_XXXXXX");
    assert_non_null(mkdtemp(folder));
}

static void expect_text(const char *path, const char *text)
{
    struct file_bytes bytes;
    assert_int_equal(file_read(NULL, path, &bytes), STP_OK);
    assert_int_equal(bytes.size, strlen(text));
    assert_memory_equal(bytes.data, text, bytes.size);
    file_release(&bytes);
}

static void test_rights(void **state)
{
    static const mode_t masks[] = { 0, 022, 077, 0137 };
    char folder[32], path[64];
    make_folder(folder);
    in_folder(folder, "a.txt", path, sizeof path);
    mode_t before = (mode_t)syscall(SYS_umask, 022);
    masks_set = 0;
    for (unsigned i = 0; i < sizeof masks / sizeof *masks; i++) {
        struct stat st;
        syscall(SYS_umask, masks[i]);
        assert_int_equal(stp_text_save(NULL, path, "one"), STP_OK);
        assert_int_equal(stat(path, &st), 0);
        assert_int_equal(st.st_mode & 07777, 0666 & ~masks[i]);
        assert_int_equal(syscall(SYS_umask, masks[i]), masks[i]);
        assert_int_equal(unlink(path), 0);
    }
    assert_int_equal(masks_set, 0);
    syscall(SYS_umask, before);
    rmdir(folder);
}

/* What was there stays whole until the new one is, and no other file is left. */
static void test_replaced(void **state)
{
    char folder[32], path[64];
    struct file_output out;
    make_folder(folder);
    in_folder(folder, "a.txt", path, sizeof path);
    assert_int_equal(stp_text_save(NULL, path, "first"), STP_OK);
    expect_text(path, "first\n");
    assert_int_equal(file_begin(NULL, path, &out), STP_OK);
    fputs("second", out.stream);
    fflush(out.stream);
    expect_text(path, "first\n");
    assert_int_equal(count_files(folder), 2);
    file_abandon(&out);
    assert_int_equal(count_files(folder), 1);
    expect_text(path, "first\n");
    assert_int_equal(stp_text_save(NULL, path, "second"), STP_OK);
    expect_text(path, "second\n");
    assert_int_equal(count_files(folder), 1);
    unlink(path);
    rmdir(folder);
}

struct many {
    char path[64];
    unsigned bad[400];
};

static void begin_one(void *context, size_t begin, size_t end, unsigned worker)
{
    struct many *many = context;
    for (size_t i = begin; i < end; i++) {
        struct file_output out;
        many->bad[i] = file_begin(NULL, many->path, &out) != STP_OK;
        if (!many->bad[i])
            fprintf(out.stream, "%zu", i);
        many->bad[i] = many->bad[i] || file_commit(NULL, &out) != STP_OK;
    }
}

/* Many threads that write one name: every one has a file of its own until it is renamed. */
static void test_many_threads(void **state)
{
    const struct stp_env env = { .threads = 8 };
    char folder[32];
    static struct many many;
    make_folder(folder);
    in_folder(folder, "a.txt", many.path, sizeof many.path);
    parallel_for(&env, 400, 16, begin_one, &many);
    for (unsigned i = 0; i < 400; i++)
        assert_int_equal(many.bad[i], 0);
    assert_int_equal(count_files(folder), 1);
    unlink(many.path);
    rmdir(folder);
}

static void swallow(void *user, enum stp_log_level level, const char *line)
{
    unsigned *lines = user;
    (*lines)++;
}

static void test_failures(void **state)
{
    char folder[32], path[64];
    unsigned lines = 0;
    const struct stp_env env = { .log = swallow, .user = &lines };
    make_folder(folder);
    in_folder(folder, "none/a.txt", path, sizeof path);
    assert_int_equal(stp_text_save(&env, path, "x"), STP_ERROR_IO);
    assert_int_equal(lines, 1);
    in_folder(folder, "a.txt", path, sizeof path);
    for (unsigned n = 1; n <= 2; n++) {
        mem_fail_at(n);
        assert_int_equal(stp_text_save(&env, path, "x"), STP_ERROR_MEMORY);
        mem_fail_at(0);
        assert_int_equal(lines, 1 + n);
    }
    assert_int_equal(count_files(folder), 0);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rights),
        cmocka_unit_test(test_replaced),
        cmocka_unit_test(test_many_threads),
        cmocka_unit_test(test_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
