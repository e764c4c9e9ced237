/* One scene, grouped at several overlaps: each is found once and shown as asked. */
#ifndef STP_PREPARE_GROUPINGS_H
#define STP_PREPARE_GROUPINGS_H

#include "scene/scene.h"

#define MAX_GROUPINGS 8

struct grouping_at {
    double asked;
    struct stp_grouping facts;
    uint8_t *group;
    uint32_t version; /* of the scene's groups while it is shown */
};
struct groupings {
    struct stp_scene *scene;
    unsigned count;
    struct grouping_at at[MAX_GROUPINGS];
    struct grouping_at before; /* what the scene had to begin with */
};

/* Remembers the grouping that the scene has. */
void groupings_begin(struct groupings *groupings, struct stp_scene *scene);
/* Groups the scene at this overlap when it was not yet, and shows the scene in that grouping. What
 * group_warn would say is the caller's to say, of the overlap that it takes. */
enum stp_result groupings_use(const struct stp_env *env, struct groupings *groupings,
                              const struct stp_group_params *params, double overlap);
/* The scene is as it was; or, keep, it stays grouped at the overlap shown last. */
void groupings_end(struct groupings *groupings, bool keep);

#endif
