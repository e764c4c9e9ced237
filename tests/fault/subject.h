/* What the tests of failing calls share: the stand-in loader's controls, and a plan that is
 * rendered again and again on one context. */
#ifndef TEST_FAULT_SUBJECT_H
#define TEST_FAULT_SUBJECT_H

#include "pass/device.h"

#include "fault.h"
#include "gpu/gpu.h"
#include "ways.h"

struct fault_controls {
    fault_arm_fn *arm;
    fault_discrete_fn *discrete;
    fault_crowd_fn *crowd;
    fault_read_fn *read;
};
/* Fails the test when libvulkan.so.1 is not the stand-in. */
struct fault_controls find_faults(void);

/* A device without a context, whose lines are counted and whose work is on one thread: calls and
 * allocations then come in the same order every time. */
void device_silent(struct device *device);

struct subject {
    struct fault_controls fault;
    struct device device;
    const struct stp_scene *scene;
    struct stp_plan *plan;
    struct stp_image *image; /* when nothing fails */
    const char *what;
    unsigned live; /* the context's own objects */
    unsigned repeat;
    bool warm; /* the context keeps pipelines between renders; else every render makes all */
    bool made; /* the last render got as far as having its pipelines */
};
/* The subject must not move. */
void subject_open(struct subject *s, const struct stp_scene *scene, const struct way *way,
                  unsigned repeat);
enum stp_result subject_render(struct subject *s, struct stp_image **image);
/* After every render, also of a context's own. */
void subject_rendered(struct subject *s);
/* From here on the context keeps the pipelines: cold renders, up to where those stand, and warm
 * ones have every call and every allocation between them. */
void subject_warm(struct subject *s);
void subject_close(struct subject *s);

/* No wrong use so far, and exactly `live` objects. */
void no_misuse(const struct fault_controls *fault, const char *what, unsigned live);

/* A few splats, each a group of its own. */
struct stp_scene *small_scene(void);

#endif
