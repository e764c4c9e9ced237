#include "base/thread.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

#define MAX_THREADS 256

struct team {
    range_fn fn;
    void *context;
    size_t count, grain;
    atomic_size_t next;
};

struct member {
    struct team *team;
    unsigned worker;
};

unsigned thread_count(const struct stp_env *env)
{
    long n = env && env->threads ? (long)env->threads : sysconf(_SC_NPROCESSORS_ONLN);
    return n < 1 ? 1 : n > MAX_THREADS ? MAX_THREADS : (unsigned)n;
}

static void *work(void *argument)
{
    struct member *member = argument;
    struct team *team = member->team;
    for (;;) {
        size_t begin = atomic_fetch_add(&team->next, team->grain);
        if (begin >= team->count)
            return NULL;
        size_t left = team->count - begin;
        team->fn(team->context, begin, begin + (left < team->grain ? left : team->grain),
                 member->worker);
    }
}

void parallel_for(const struct stp_env *env, size_t count, size_t grain, range_fn fn, void *context)
{
    unsigned threads = thread_count(env);
    if (count == 0)
        return;
    if (grain == 0)
        grain = (count + threads - 1) / threads;
    if (threads > (count + grain - 1) / grain)
        threads = (unsigned)((count + grain - 1) / grain);
    struct team team = { .fn = fn, .context = context, .count = count, .grain = grain };
    struct member members[MAX_THREADS];
    pthread_t handles[MAX_THREADS];
    unsigned started = 1;
    for (unsigned i = 0; i < threads; i++)
        members[i] = (struct member){ &team, i };
    while (started < threads &&
           pthread_create(&handles[started], NULL, work, &members[started]) == 0)
        started++;
    work(&members[0]);
    for (unsigned i = 1; i < started; i++)
        pthread_join(handles[i], NULL);
}
