#include "prepare/phong_holders.h"

#include "base/log.h"
#include "base/memory.h"

enum stp_result holders_find(const struct stp_env *env, const struct fit_cloud *cloud,
                             const struct patch_set *set, struct holders *h)
{
    size_t total = 0;
    for (size_t i = 0; i < set->count; i++)
        total += set->patch[i].count;
    struct holders made = { mem_zalloc(cloud->count + 1, sizeof *made.begin),
                            mem_alloc(total, sizeof *made.patch) };
    if (!made.begin || !made.patch) {
        holders_release(&made);
        return log_no_memory(env, total * sizeof *made.patch, "the patches of sites");
    }
    for (size_t i = 0; i < set->count; i++)
        for (uint32_t k = 0; k < set->patch[i].count; k++)
            made.begin[set->patch[i].member[k]]++;
    for (size_t i = 1; i <= cloud->count; i++)
        made.begin[i] += made.begin[i - 1];
    for (size_t i = set->count; i-- > 0;) /* from the end: each row's end becomes its begin */
        for (uint32_t k = set->patch[i].count; k-- > 0;)
            made.patch[--made.begin[set->patch[i].member[k]]] = (uint32_t)i;
    *h = made;
    return STP_OK;
}

void holders_release(struct holders *h)
{
    mem_free(h->begin);
    mem_free(h->patch);
    *h = (struct holders){ 0 };
}
