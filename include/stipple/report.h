/* Speed against error: every method that applies to a scene, timed and measured in one run. */
#ifndef STIPPLE_REPORT_H
#define STIPPLE_REPORT_H

#include <stipple/render.h>

#ifdef __cplusplus
extern "C" {
#endif

struct stp_report_params {
    struct stp_render_params render; /* what every configuration shares; method, path, payload,
                                        voronoi, transparency and axis_* are swept, samples and
                                        aovs are not used */
    struct stp_group_params group;   /* relax and max_groups; overlap is swept */
    unsigned rounds;                 /* visits to each configuration, three timed frames each;
                                        0: 3, or 2 when quick */
    bool quick;                      /* fewer configurations and rounds */
    double exposure;                 /* stops, before FLIP */
    const char *title;               /* of the scene; NULL: "scene" */
    const char *command;             /* printed as what made the report; NULL: nothing */
};

/* Sweeps methods and parameters over one camera and writes report.csv, report.svg, report.md and
 * samples.csv and error_*.png into `folder`, which must exist (docs/report.md). The scene must be
 * prepared; its grouping is as before afterwards, and a transparent one may have been covered. */
STP_API enum stp_result stp_report(const struct stp_env *env, struct stp_context *context,
                                   struct stp_scene *scene, const struct stp_camera *camera,
                                   const struct stp_report_params *params, const char *folder);

#ifdef __cplusplus
}
#endif
#endif
