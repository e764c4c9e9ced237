/* Preloaded into the command: the n-th allocation (ALLOCATION_AT) of the program itself, of the C
 * library on its behalf, or of the libraries for JSON and pictures returns NULL. ALLOCATION_REPORT
 * names a file that gets how many there were. C++ and Vulkan drivers are left alone: they abort. */
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *old, size_t size);
EXPORT void *malloc(size_t size);
EXPORT void *calloc(size_t count, size_t size);
EXPORT void *realloc(void *old, size_t size);

static atomic_ulong count;
static unsigned long fail_at;
static bool started;

__attribute__((constructor)) static void start(void)
{
    const char *text = getenv("ALLOCATION_AT");
    fail_at = text ? strtoul(text, NULL, 10) : 0;
    started = true;
}

__attribute__((destructor)) static void report(void)
{
    const char *path = getenv("ALLOCATION_REPORT");
    unsigned long counted = count;
    started = false;
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file)
        return;
    fprintf(file, "%lu\n", counted);
    fclose(file);
}

static bool is_ours(const char *library)
{
    static const char *const names[] = { "stipple",   "libc.so", "libcjson.",
                                         "libpng16.", "libz.",   "libOpenEXRCore" };
    const char *slash = strrchr(library, '/');
    library = slash ? slash + 1 : library;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strncmp(library, names[i], strlen(names[i])) == 0)
            return true;
    return false;
}

static bool fails(void *caller)
{
    Dl_info info;
    if (!started || !dladdr(caller, &info) || !info.dli_fname || !is_ours(info.dli_fname))
        return false;
    if (atomic_fetch_add(&count, 1) + 1 != fail_at)
        return false;
    errno = ENOMEM;
    return true;
}

void *malloc(size_t size)
{
    return fails(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
}

void *calloc(size_t items, size_t size)
{
    return fails(__builtin_return_address(0)) ? NULL : __libc_calloc(items, size);
}

void *realloc(void *old, size_t size)
{
    return fails(__builtin_return_address(0)) ? NULL : __libc_realloc(old, size);
}
