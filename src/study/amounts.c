/* The amounts that frames' times are predicted from, as log lines: what prices are fitted to
 * (tools/bench_auto.py prices). */
#include "study/study.h"

#include <stdio.h>

#include "base/log.h"

#define LINE_SIZE 480

void study_log_amounts(const struct stp_env *env, enum plan_cost kind,
                       const double amount[PLAN_TERMS], double ms)
{
    char line[LINE_SIZE];
    int length = 0;
    for (int t = 0; t < PLAN_TERMS && length < LINE_SIZE; t++)
        if (amount[t] > 0)
            length += snprintf(line + length, (size_t)(LINE_SIZE - length), "; %s %.9g",
                               plan_term_name((enum plan_term)t), amount[t]);
    log_info(env, "cost of %s: %.6g ms%s", plan_cost_name(kind), ms, length ? line : "");
}

enum stp_result study_log_costs(struct study *study)
{
    struct stp_render_params params = study->params.render;
    struct survey survey;
    params.samples = params.aovs = 0;
    if (study->scene->volume || study->scene->facts.transparent)
        return STP_OK;
    enum stp_result result =
        survey_make(&study->quiet, study->scene, study->camera, &params, &survey);
    if (result != STP_OK)
        return result;
    for (unsigned i = 0; i < study->frame_count; i++) {
        const struct study_frame *frame = &study->frame[i];
        const struct plan_offer *offer = plan_offer_of(frame->plan);
        double amount[PLAN_TERMS] = { 0 };
        if (!offer || frame->config.epsilon_scale != 1)
            continue;
        enum plan_cost kind = offer->cost(frame->plan, &survey, amount);
        study_log_amounts(study->env, kind, amount, study->report.row[i].ms.median);
    }
    survey_release(&survey);
    return STP_OK;
}
