#include "hard.h"

/* How a case came out by one way. */
struct outcome {
    struct verdict verdict;
    double truth, twin; /* over the bound; dB */
    bool right;
};

/* What is shared by the ways of one case. */
struct judging {
    const struct hard_options *o;
    struct device *device;
    const struct hard_case *c;
    char slug[HARD_SLUG]; /* of files */
    struct hard_scene s;
    const struct hard_way *ways;
    unsigned way_count;
    struct truth truth[2]; /* for depths as they are, and quantised */
    struct outcome outcome[HARD_WAYS];
};

static struct stp_plan *plan_of(struct judging *j, const struct stp_scene *scene,
                                const struct stp_camera *camera, const struct hard_way *way)
{
    struct stp_plan *plan = NULL;
    struct stp_render_params p = hard_way_params(way, &j->s.params);
    if (device_plan(j->device, scene, camera, &p, &plan) != STP_OK)
        fail_msg("%s by %s: no plan: %s", j->c->name, way->name, j->device->last);
    return plan;
}

static const struct tolerance *tolerance_of(const struct stp_plan *plan)
{
    if (plan->transparency == STP_TRANSPARENCY_EXACT)
        return &layers_tolerance;
    if (plan->payload == STP_PAYLOAD_PACKED)
        return &packed_tolerance;
    return plan->method == STP_METHOD_EXACT ? &exact_tolerance : &float_tolerance;
}

/* dB: one pixel of a picture of a tenth as many weighs ten times. */
#define FEW_PIXELS 10

/* What is less than any surface's is of scenes as they are: light of 10^6 on an outline. */
static double grouped_bound(const struct judging *j)
{
    bool surface = j->c->grouped >= HARD_GROUPED;
    return !j->o->varied ? j->c->grouped : surface ? HARD_GROUPED : -INFINITY;
}

/* Against the reference. Groups of many splats lose what the paper says they lose: only the noise
 * is bounded. */
static bool judge_way(struct judging *j, const struct hard_way *way, const struct stp_plan *plan,
                      const struct stp_image *image, struct outcome *out)
{
    struct truth *truth = &j->truth[plan->payload == STP_PAYLOAD_PACKED];
    const struct tolerance *t = tolerance_of(plan);
    double fragile = j->c->fragile > 0 ? j->c->fragile : t->fragile;
    if (!truth->image)
        truth_make(j->s.scene, plan, truth);
    struct verdict v = judge_against(truth, plan->frame.epsilon, image, t);
    out->verdict = v;
    if (hard_approximates(way)) /* and may cover more: where radii grow for groups to cover */
        return !(j->c->grouped > 0) || v.psnr >= j->c->grouped;
    /* The case's own check then says what is right. */
    bool undecided = v.covered > 0 && v.fragile >= v.covered;
    if (undecided && !(fragile >= 1 && j->c->check))
        return false;
    if ((double)v.fragile > fragile * (double)v.covered + 8)
        return false;
    if (plan->method == STP_METHOD_DEFERRED && j->s.scene->facts.splats > STP_MAX_GROUPS)
        return v.psnr >= grouped_bound(j);
    if (plan->payload == STP_PAYLOAD_PACKED && j->c->packed > 0)
        return v.psnr >= j->c->packed - (j->o->varied ? FEW_PIXELS : 0);
    return v.off == 0 && !v.noisy;
}

static struct stp_image *render_way(struct judging *j, const struct stp_scene *scene,
                                    const struct stp_camera *camera, const struct hard_way *way,
                                    struct outcome *judged)
{
    struct stp_plan *plan = plan_of(j, scene, camera, way);
    bool is_truth = way->method == STP_METHOD_REFERENCE;
    struct stp_image *image = is_truth ? hard_reference(scene, camera, &plan->params)
                                       : device_render_plan(j->device, scene, plan);
    if (judged && !is_truth)
        judged->right = judge_way(j, way, plan, image, judged);
    stp_plan_destroy(&plan);
    return image;
}

static void judge_twin(struct judging *j, const struct hard_way *way, const struct stp_image *image,
                       struct outcome *out)
{
    struct stp_image *twin = render_way(j, j->s.twin, &j->s.twin_camera, way, NULL);
    if (j->c->twin == INFINITY) {
        expect_same_bits(image, twin, j->c->name);
        out->twin = INFINITY;
    } else {
        out->twin = hard_psnr(image, twin);
    }
    out->right &= out->twin >= j->c->twin;
    stp_image_destroy(&twin);
}

static void one_way(struct judging *j, unsigned w)
{
    const struct hard_way *way = &j->ways[w];
    struct outcome *out = &j->outcome[w];
    *out = (struct outcome){ .right = true, .verdict.psnr = INFINITY };
    struct stp_image *image = render_way(j, j->s.scene, &j->s.camera, way, out);
    out->right &= hard_sound(image);
    if (j->c->check && !hard_approximates(way)) {
        out->truth = j->c->check(&j->s, image);
        out->right &= out->truth <= 1;
    }
    if (j->s.twin)
        judge_twin(j, way, image, out);
    hard_keep(j->o, &j->s, j->slug, image, w);
    stp_image_destroy(&image);
    const struct verdict *v = &out->verdict;
    if (!out->right || getenv("STP_TEST_VERDICTS"))
        print_message("%s by %s: %s: %zu covered, %zu fragile, %zu off, %.1f dB, colour %.3g, "
                      "normal %.3g, depth %.3g; truth %.3g; twin %.1f dB\n",
                      j->c->name, way->name, out->right ? "right" : "WRONG", v->covered, v->fragile,
                      v->off, v->psnr, v->worst_color, v->worst_normal, v->worst_depth, out->truth,
                      out->twin);
}

static void print_db(FILE *file, double db)
{
    if (db > 200)
        fprintf(file, " same |");
    else
        fprintf(file, " %.0f |", db);
}

/* | case, outcome | picture | dB by every way but the reference | truth or twin | */
static void print_row(const struct judging *j)
{
    FILE *file = j->o->table ? fopen(j->o->table, "a") : NULL;
    double truth = 0, twin = INFINITY;
    if (!file)
        return;
    fprintf(file, "| **%s.** %s | ![](images/hard/%s.png) |", j->c->name, j->c->outcome, j->slug);
    for (unsigned w = 0; w < j->way_count; w++) {
        if (j->ways[w].method != STP_METHOD_REFERENCE)
            print_db(file, j->outcome[w].verdict.psnr);
        truth = fmax(truth, j->outcome[w].truth);
        twin = fmin(twin, j->outcome[w].twin);
    }
    for (unsigned w = j->way_count; j->ways == hard_layer_ways && w < HARD_LAYER_WAYS; w++)
        fprintf(file, " |"); /* ways that draw neither glass nor ellipses */
    if (j->s.twin && j->c->twin == INFINITY)
        fprintf(file, " the same bits |\n");
    else if (j->s.twin && twin == INFINITY)
        fprintf(file, " the same |\n");
    else if (j->s.twin)
        fprintf(file, " %.0f dB |\n", twin);
    else if (j->c->check)
        fprintf(file, " %.2g of its bound |\n", truth);
    else
        fprintf(file, " |\n");
    fclose(file);
}

void hard_say(const struct hard_options *o, const char *family, const struct hard_case *c)
{
    FILE *file = o->table ? fopen(o->table, "a") : NULL;
    if (!file)
        return;
    bool layers = strcmp(family, hard_layers.name) == 0; /* whose table has one way less */
    fprintf(file, "| **%s.** %s | | | | | | |%s held |\n", c->name, c->outcome, layers ? "" : " |");
    fclose(file);
}

void hard_judge(const struct hard_options *o, struct device *device, const char *family,
                const struct hard_case *c)
{
    struct judging j = { .o = o, .device = device, .c = c };
    bool right = true;
    hard_slug(family, c, j.slug);
    c->make(o, &j.s);
    j.ways = hard_ways_of(j.s.scene, &j.way_count);
    hard_group(j.s.scene);
    if (j.s.twin)
        hard_group(j.s.twin);
    for (unsigned w = 0; w < j.way_count; w++) {
        one_way(&j, w);
        right &= j.outcome[w].right;
    }
    print_row(&j);
    for (int i = 0; i < 2; i++)
        truth_destroy(&j.truth[i]);
    stp_scene_destroy(&j.s.scene);
    stp_scene_destroy(&j.s.twin);
    assert_true(right);
}
