/* Transfer functions in JSON. */
#ifndef STP_SCENE_TRANSFER_JSON_H
#define STP_SCENE_TRANSFER_JSON_H

#include "base/json.h"
#include "scene/volume.h"

enum stp_result transfer_from_json(const struct json_at *at, const cJSON *json,
                                   struct transfer_function *function);

#endif
