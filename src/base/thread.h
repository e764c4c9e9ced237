/* Fork-join over an index range. Results must not depend on how the range is cut. */
#ifndef STP_BASE_THREAD_H
#define STP_BASE_THREAD_H

#include <stipple/result.h>

/* Processes [begin, end). `worker` is in [0, thread_count(env)) and unique among running calls. */
typedef void (*range_fn)(void *context, size_t begin, size_t end, unsigned worker);

unsigned thread_count(const struct stp_env *env);

/* Blocks of `grain` indices are handed out in order to all threads; returns when all are done.
 * grain 0 cuts the range into one block a thread. Never fails: it runs on fewer threads when
 * threads cannot be made. */
void parallel_for(const struct stp_env *env, size_t count, size_t grain, range_fn fn,
                  void *context);

#endif
