/* Calibrations as JSON, in profiles and in the cache. */
#ifndef STP_PLAN_PROFILE_H
#define STP_PLAN_PROFILE_H

#include <stipple/plan.h>

#include "base/json.h"

/* Of Mesa's software device on two cores; other devices start from it too, until they are
 * calibrated. */
void calibration_built_in(struct stp_calibration *calibration);
/* Kinds and terms by name, those that are 0 left out. NULL: out of memory. */
cJSON *calibration_to_json(const struct stp_calibration *calibration);
/* `root` holds a "calibration", or not: then *calibration is untouched. */
enum stp_result calibration_from_json(const struct json_at *at, const cJSON *root,
                                      struct stp_calibration *calibration);

#endif
