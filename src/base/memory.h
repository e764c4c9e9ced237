/* Checked allocation. Every allocation of the CPU half goes through here, so that a test can make
 * the n-th one fail. Sizes are products checked for overflow. */
#ifndef STP_BASE_MEMORY_H
#define STP_BASE_MEMORY_H

#include <stddef.h>

void *mem_alloc(size_t count, size_t size);              /* NULL on failure or overflow */
void *mem_zalloc(size_t count, size_t size);             /* zeroed */
void *mem_realloc(void *old, size_t count, size_t size); /* old stays valid on failure */
void mem_free(void *pointer);

/* Tests: fail the n-th allocation from now (1 is the next); 0 turns it off. */
void mem_fail_at(unsigned long n);
unsigned long mem_count(void); /* allocations since the last mem_fail_at */

#endif
