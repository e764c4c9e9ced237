#include "base/memory.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/* Test hooks only: the one exception to "no global state". */
static atomic_ulong allocations;
static atomic_ulong fail_at;

void mem_fail_at(unsigned long n)
{
    atomic_store(&allocations, 0);
    atomic_store(&fail_at, n);
}

unsigned long mem_count(void)
{
    return atomic_load(&allocations);
}

static bool refused(size_t count, size_t size)
{
    unsigned long n = atomic_fetch_add(&allocations, 1) + 1;
    return n == atomic_load(&fail_at) || (size != 0 && count > SIZE_MAX / size);
}

/* Never 0: an empty array is not a failure. */
static size_t product(size_t count, size_t size)
{
    size_t bytes = count * size;
    return bytes ? bytes : 1;
}

void *mem_alloc(size_t count, size_t size)
{
    return refused(count, size) ? NULL : malloc(product(count, size));
}

void *mem_zalloc(size_t count, size_t size)
{
    return refused(count, size) ? NULL : calloc(count ? count : 1, size ? size : 1);
}

void *mem_realloc(void *old, size_t count, size_t size)
{
    return refused(count, size) ? NULL : realloc(old, product(count, size));
}

void mem_free(void *pointer)
{
    free(pointer);
}
