/* Few patches that cover every site: greedy selection among grown candidates, then global
 * relaxation (Wu & Kobbelt). */
#ifndef STP_PREPARE_PHONG_COVER_H
#define STP_PREPARE_PHONG_COVER_H

#include "prepare/phong_fit.h"

struct patch_set {
    size_t count, capacity;
    struct patch *patch; /* owned */
};
void patch_set_release(struct patch_set *set);

/* Every site of the cloud is a member of at least one patch, and no patch could be left out. */
enum stp_result patches_cover(const struct stp_env *env, const struct fit_cloud *cloud,
                              const struct fit_limits *limits, struct patch_set *set);

#endif
