/* Files that appear whole, with the rights of any new file, and without the process's mask being
 * touched: another thread's files would get other rights meanwhile. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
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

static unsigned syncs;
static int sync_error;

/* The same; it fails with sync_error, if any. */
int fsync(int fd)
{
    syncs++;
    if (!sync_error)
        return (int)syscall(SYS_fsync, fd);
    errno = sync_error;
    return -1;
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

/* A link stays a link, also in a row of them; what it names is written, there or not yet. */
static void test_links(void **state)
{
    char folder[32], sub[64], file[64], first[64], second[64], dangling[64];
    struct stat st;
    make_folder(folder);
    in_folder(folder, "sub", sub, sizeof sub);
    in_folder(folder, "sub/a.txt", file, sizeof file);
    in_folder(folder, "sub/first", first, sizeof first);
    in_folder(folder, "second", second, sizeof second);
    in_folder(folder, "dangling", dangling, sizeof dangling);
    assert_int_equal(mkdir(sub, 0777), 0);
    assert_int_equal(symlink("a.txt", first), 0);
    assert_int_equal(symlink(first, second), 0);
    assert_int_equal(symlink("sub/b.txt", dangling), 0);
    assert_int_equal(stp_text_save(NULL, file, "old"), STP_OK);
    assert_int_equal(stp_text_save(NULL, second, "new"), STP_OK);
    expect_text(file, "new\n");
    assert_true(lstat(first, &st) == 0 && S_ISLNK(st.st_mode));
    assert_true(lstat(second, &st) == 0 && S_ISLNK(st.st_mode));
    assert_int_equal(stp_text_save(NULL, dangling, "made"), STP_OK);
    assert_true(lstat(dangling, &st) == 0 && S_ISLNK(st.st_mode));
    in_folder(folder, "sub/b.txt", file, sizeof file);
    expect_text(file, "made\n");
    assert_int_equal(count_files(folder), 3);
    assert_int_equal(count_files(sub), 3);
    unlink(file);
    in_folder(folder, "sub/a.txt", file, sizeof file);
    unlink(file);
    unlink(first);
    unlink(second);
    unlink(dangling);
    rmdir(sub);
    rmdir(folder);
}

/* What is replaced leaves its rights, whatever the mask; no moment shows the new one to more. */
static void test_kept_rights(void **state)
{
    static const mode_t modes[] = { 0600, 0640, 0444, 0777, 0666 };
    char folder[32], path[64];
    make_folder(folder);
    in_folder(folder, "a.txt", path, sizeof path);
    mode_t before = (mode_t)syscall(SYS_umask, 027);
    for (unsigned i = 0; i < sizeof modes / sizeof *modes; i++) {
        struct file_output out;
        struct stat st;
        assert_int_equal(stp_text_save(NULL, path, "one"), STP_OK);
        assert_int_equal(chmod(path, modes[i]), 0);
        assert_int_equal(file_begin(NULL, path, &out), STP_OK);
        assert_int_equal(stat(out.temporary, &st), 0);
        assert_int_equal(st.st_mode & 07777, modes[i]);
        assert_int_equal(file_commit(NULL, &out), STP_OK);
        assert_int_equal(stat(path, &st), 0);
        assert_int_equal(st.st_mode & 07777, modes[i]);
        unlink(path);
    }
    syscall(SYS_umask, before);
    rmdir(folder);
}

/* The longest name that there is: the temporary's is cut, at a whole character. */
static void test_long_names(void **state)
{
    char folder[32], name[256], path[320];
    make_folder(folder);
    for (unsigned wide = 0; wide < 2; wide++) {
        struct file_output out;
        for (unsigned i = 0; i < 255; i++)
            name[i] = wide && i > 0 ? (i % 2 ? '\xc3' : '\xa9') : 'a';
        name[255] = 0;
        in_folder(folder, name, path, sizeof path);
        assert_int_equal(file_begin(NULL, path, &out), STP_OK);
        const char *cut = strrchr(out.temporary, '.');
        assert_true(strlen(strrchr(out.temporary, '/') + 1) <= 255);
        assert_true((unsigned char)cut[-1] == (wide ? 0xa9 : 'a'));
        fputs("long\n", out.stream);
        assert_int_equal(file_commit(NULL, &out), STP_OK);
        expect_text(path, "long\n");
        assert_int_equal(count_files(folder), 1);
        unlink(path);
    }
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
    for (unsigned n = 1; n <= 3; n++) {
        mem_fail_at(n);
        assert_int_equal(stp_text_save(&env, path, "x"), STP_ERROR_MEMORY);
        mem_fail_at(0);
        assert_int_equal(lines, 1 + n);
    }
    assert_int_equal(count_files(folder), 0);
    rmdir(folder);
}

static void keep(void *user, enum stp_log_level level, const char *line)
{
    snprintf(user, 512, "%s", line);
}

/* It is on the disk before it is in its place; where that fails, the old one stays. */
static void test_synced(void **state)
{
    char folder[32], path[64], line[512] = "";
    const struct stp_env env = { .log = keep, .user = line };
    make_folder(folder);
    in_folder(folder, "a.txt", path, sizeof path);
    syncs = 0;
    assert_int_equal(stp_text_save(&env, path, "first"), STP_OK);
    assert_int_equal(syncs, 1);
    sync_error = EIO;
    assert_int_equal(stp_text_save(&env, path, "second"), STP_ERROR_IO);
    assert_non_null(strstr(line, strerror(EIO)));
    expect_text(path, "first\n");
    assert_int_equal(count_files(folder), 1);
    sync_error = EINVAL; /* a file system that has no such thing */
    assert_int_equal(stp_text_save(&env, path, "third"), STP_OK);
    expect_text(path, "third\n");
    sync_error = 0;
    unlink(path);
    rmdir(folder);
}

/* A write that failed some time ago is not given the reason of what failed since. */
static void test_stale_reason(void **state)
{
    static char much[1 << 16];
    char folder[32], path[64], line[512] = "";
    const struct stp_env env = { .log = keep, .user = line };
    struct rlimit before, little;
    struct file_output out;
    make_folder(folder);
    in_folder(folder, "a.txt", path, sizeof path);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    little = before;
    little.rlim_cur = 4096;
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &little), 0);
    assert_int_equal(file_begin(&env, path, &out), STP_OK);
    setvbuf(out.stream, NULL, _IONBF, 0);
    assert_true(fwrite(much, 1, sizeof much, out.stream) < sizeof much);
    errno = ENOENT;
    assert_int_equal(file_commit(&env, &out), STP_ERROR_IO);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, handler);
    assert_non_null(strstr(line, "a.txt: cannot write: "));
    assert_null(strstr(line, strerror(ENOENT)));
    assert_int_equal(count_files(folder), 0);
    rmdir(folder);
}

static void test_refused(void **state)
{
    char folder[32], path[64], line[512] = "";
    const struct stp_env env = { .log = keep, .user = line };
    struct stat st;
    make_folder(folder);
    in_folder(folder, "pipe", path, sizeof path);
    assert_int_equal(mkfifo(path, 0666), 0);
    assert_int_equal(stp_text_save(&env, path, "x"), STP_ERROR_IO);
    assert_non_null(strstr(line, "no regular file"));
    assert_true(lstat(path, &st) == 0 && S_ISFIFO(st.st_mode));
    unlink(path);
    assert_int_equal(symlink("pipe", path), 0);
    assert_int_equal(stp_text_save(&env, path, "x"), STP_ERROR_IO);
    assert_non_null(strstr(line, strerror(ELOOP)));
    assert_int_equal(count_files(folder), 1);
    unlink(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rights),       cmocka_unit_test(test_replaced),
        cmocka_unit_test(test_links),        cmocka_unit_test(test_kept_rights),
        cmocka_unit_test(test_long_names),   cmocka_unit_test(test_many_threads),
        cmocka_unit_test(test_failures),     cmocka_unit_test(test_synced),
        cmocka_unit_test(test_stale_reason), cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
