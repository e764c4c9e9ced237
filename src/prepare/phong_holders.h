/* Which patches hold each site. */
#ifndef STP_PREPARE_PHONG_HOLDERS_H
#define STP_PREPARE_PHONG_HOLDERS_H

#include "prepare/phong_cover.h"

/* Rows in the sites' order; patches of a row ascend. */
struct holders {
    size_t *begin; /* sites + 1 */
    uint32_t *patch;
};

enum stp_result holders_find(const struct stp_env *env, const struct fit_cloud *cloud,
                             const struct patch_set *set, struct holders *h);
void holders_release(struct holders *h);

#endif
