/* What some of the specialisation constants hold. */
#ifndef STP_PLAN_CONSTANTS_H
#define STP_PLAN_CONSTANTS_H

#include "shared/constants.h"

/* Bits of PLAN_AOVS: albedo and weight; id, fragments and what goes with them; layers too. */
#define PLAN_AOVS_ALBEDO 1u
#define PLAN_AOVS_ID     2u
#define PLAN_AOVS_LAYERS 4u

/* What the depth of a host's image is copied as, where it cuts layers. */
enum plan_host_depth {
    PLAN_HOST_DEPTH_NONE,
    PLAN_HOST_DEPTH_FLOAT,
    PLAN_HOST_DEPTH_24, /* in the low bits of a word */
    PLAN_HOST_DEPTH_16,
};

#endif
