/* What auto would take, asked before anything is timed: it joins the sweep. */
#include "study/study.h"

#include "base/log.h"
#include "base/memory.h"
#include "scene/scene.h"

static const double bounds[] = { 1e-2, 3e-3, 1e-3, 1e-4, 1e-5 };
#define BOUNDS (sizeof bounds / sizeof *bounds)
_Static_assert(BOUNDS <= REPORT_MAX_PICKS, "a report holds all picks");

/* That no method is sure of a bound is what the table says, not a warning. */
static void log_no_warning(void *user, enum stp_log_level level, const char *line)
{
    const struct stp_env *env = user;
    if (level == STP_LOG_ERROR)
        log_error(env, STP_ERROR_ARGUMENT, "%s", line);
    else if (level == STP_LOG_INFO)
        log_info(env, "%s", line);
}

/* stp_choose leaves the scene grouped as it chose; the study has groupings of its own. */
static enum stp_result choose(struct study *study, double bound, struct stp_choice *choice)
{
    struct stp_scene *scene = study->scene;
    struct stp_env env = study->quiet;
    struct stp_render_params params = study->params.render;
    struct stp_group_params group = study->params.group;
    uint8_t *kept = scene->splats.group;
    struct stp_grouping facts = scene->facts.grouping;
    uint32_t version = scene->version.groups;
    env.log = log_no_warning;
    env.user = &study->quiet;
    params.max_error = bound;
    params.samples = params.aovs = 0;
    group.overlap = 0;
    scene->splats.group = NULL;
    scene->facts.grouping = (struct stp_grouping){ 0 };
    enum stp_result result = stp_choose(&env, scene, study->camera, &group, &params,
                                        stp_context_limits(study->context), choice);
    mem_free(scene->splats.group);
    scene->splats.group = kept;
    scene->facts.grouping = facts;
    scene->version.groups = version;
    return result;
}

static const struct stp_considered *chosen(const struct stp_choice *choice)
{
    for (unsigned i = 0; i < choice->count; i++)
        if (choice->considered[i].verdict == STP_VERDICT_CHOSEN)
            return &choice->considered[i];
    return NULL;
}

static bool is_row(const struct study_frame *frame, const struct stp_considered *c)
{
    bool voronoi = c->overlap == 0 || frame->plan->voronoi == c->voronoi;
    return frame->config.method == c->method && frame->plan->path == c->path &&
           frame->plan->payload == c->payload && voronoi && frame->config.overlap == c->overlap &&
           frame->config.transparency == c->transparency &&
           frame->config.peel_layers == c->peel_layers && frame->config.epsilon_scale == 1;
}

/* The row of what was chosen; a new one where the sweep has none. */
static enum stp_result find_row(struct study *study, const struct stp_considered *c, unsigned *row)
{
    const struct study_config config = {
        .method = c->method,
        .path = c->path,
        .payload = c->method == STP_METHOD_EXACT || c->method == STP_METHOD_DEFERRED
                       ? c->payload
                       : STP_PAYLOAD_AUTO,
        .voronoi = c->overlap > 0 ? c->voronoi : STP_VORONOI_OFF,
        .overlap = c->overlap,
        .epsilon_scale = 1,
        .transparency = c->transparency,
        .peel_layers = c->peel_layers,
    };
    for (*row = 0; *row < study->frame_count; (*row)++)
        if (is_row(&study->frame[*row], c))
            return STP_OK;
    return study_try(study, &config);
}

enum stp_result study_pick(struct study *study)
{
    if (study->scene->volume)
        return STP_OK; /* its order is not what --max-error decides */
    struct stp_choice *choice = mem_alloc(1, sizeof *choice);
    enum stp_result result =
        choice ? STP_OK : log_no_memory(study->env, sizeof *choice, "a choice");
    for (unsigned i = 0; result == STP_OK && i < BOUNDS; i++) {
        unsigned row = 0;
        result = choose(study, bounds[i], choice);
        const struct stp_considered *c = result == STP_OK ? chosen(choice) : NULL;
        if (!c)
            break;
        result = find_row(study, c, &row);
        if (result == STP_OK && row < study->frame_count)
            study->report.pick[study->report.pick_count++] =
                (struct report_pick){ bounds[i], row, choice->params.prediction.milliseconds,
                                      choice->params.prediction.error, choice->met };
    }
    mem_free(choice);
    return result;
}
