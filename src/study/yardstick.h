/* How fast the device is just now: one frame, drawn again and again. A shared machine has spells of
 * seconds in which every frame takes up to 1.7 times as long, and what is measured then says little
 * of the rest. */
#ifndef STP_STUDY_YARDSTICK_H
#define STP_STUDY_YARDSTICK_H

#include "record/record.h"

#define YARDSTICK_FRAMES 2 /* of a reading: what disturbs one of them is not a spell */

struct yardstick {
    const struct stp_scene *scene;
    struct stp_plan *plan;
    struct record_frame frame;
    double ms; /* of the last reading; 0: there is no frame, and nothing is read */
};

/* The frame that a plan without wishes draws. It has the scene and the context for as long as it
 * lasts. A scene that no plan of the device draws leaves it empty. */
enum stp_result yardstick_make(const struct stp_env *env, struct stp_context *context,
                               const struct stp_scene *scene, const struct stp_camera *camera,
                               struct yardstick *yardstick);
enum stp_result yardstick_read(const struct stp_env *env, struct yardstick *yardstick);
void yardstick_release(struct yardstick *yardstick);

#endif
