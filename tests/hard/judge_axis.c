#include "orders.h"

/* What each way leaves at most of colour, alpha and depth. A fragment's exponent is at most 4.5
 * (m^2 / 2 at the cut) after a dozen operations: 12 x 4.5 x 2^-24 = 3e-6 of its opacity; a picture
 * is a sum of them whose weights do not exceed 1, four times as much where a ray is slanted by 87
 * degrees, as corners of wide pictures are. Where the near plane cuts, erf is known to 1.5e-7. So
 * 2e-5, and as much again for what places in the picture lose: 2^-24 of their distance from its
 * middle. */
#define ROUNDING 4e-5
/* A millionth of a radian is 1e-4 pixels; a picture of kernels some pixels wide slopes by less than
 * one a pixel, and weights by 1e-6 / (1 - h). */
#define ASIDE 2e-4

#define MERGES 4
static const char *const merge_names[MERGES] = { "blend", "clip", "single", "sort" };

struct axis_judging {
    const struct hard_options *o;
    struct device *device;
    const struct hard_case *c;
    char slug[HARD_SLUG];
    struct hard_scene s;
    struct orders orders;
    struct stp_image *truth; /* in exact order */
    double db[MERGES];       /* to that, by compute */
    double worst;            /* over its bound */
};

static struct stp_image *render_as(struct axis_judging *j, const struct stp_camera *camera,
                                   unsigned merge, enum stp_path path)
{
    struct stp_render_params p = j->s.params;
    struct stp_plan *plan = NULL;
    p.method = STP_METHOD_AXIS;
    p.axis_merge = (enum stp_axis_merge)(STP_AXIS_BLEND + merge);
    p.path = path;
    if (device_plan(j->device, j->s.scene, camera, &p, &plan) != STP_OK)
        fail_msg("%s by %s: no plan: %s", j->c->name, merge_names[merge], j->device->last);
    /* An axis that the picture sees from both sides has two. */
    if (p.axis_merge == STP_AXIS_BLEND && j->s.truth[1] > 0)
        assert_in_range(plan->axis.walk_count, (unsigned)j->s.truth[1], 6);
    struct stp_image *image = device_render_plan(j->device, j->s.scene, plan);
    stp_plan_destroy(&plan);
    return image;
}

static struct stp_image *exact_order(const struct hard_scene *s)
{
    struct stp_render_params p = s->params;
    p.method = STP_METHOD_AXIS;
    p.axis_merge = STP_AXIS_REFERENCE;
    return hard_reference(s->scene, &s->camera, &p);
}

/* No order changes alpha. */
static double alpha_error(const struct axis_judging *j, const struct stp_image *image)
{
    const float *a = stp_image_find(image, "A")->data.f;
    const float *b = stp_image_find(j->truth, "A")->data.f;
    double worst = 0;
    for (size_t i = 0; i < j->orders.pixels; i++)
        if (!j->orders.fragile[i])
            worst = fmax(worst, fabs((double)a[i] - b[i]) - j->orders.slope[i]);
    return worst;
}

static void judge_picture(struct axis_judging *j, const struct stp_camera *camera, unsigned merge,
                          enum stp_path path, double bound)
{
    double h = j->s.params.axis_h < 0 ? 0 : j->s.params.axis_h > 0 ? j->s.params.axis_h : 0.85;
    struct stp_image *image = render_as(j, camera, merge, path);
    double error =
        orders_error(&j->orders, image, (enum stp_axis_merge)(STP_AXIS_BLEND + merge), h);
    double alpha = alpha_error(j, image);
    bool right = hard_sound(image) && error <= bound && alpha <= bound;
    if (!right || getenv("STP_TEST_VERDICTS"))
        print_message("%s by %s, %s%s: %s: off by %.3g, alpha %.3g, bound %.3g\n", j->c->name,
                      merge_names[merge], stp_path_name(path),
                      camera == &j->s.camera ? "" : ", aside", right ? "right" : "WRONG", error,
                      alpha, bound);
    j->worst = fmax(j->worst, right ? fmax(error, alpha) / bound : INFINITY);
    if (camera == &j->s.camera)
        hard_keep(j->o, &j->s, j->slug, image, 2 * merge + (path == STP_PATH_RASTER));
    if (camera == &j->s.camera && path == STP_PATH_COMPUTE) {
        const struct stp_compare_params how = { 0 };
        struct stp_comparison comparison;
        assert_int_equal(stp_compare(NULL, image, j->truth, &how, &comparison), STP_OK);
        j->db[merge] = comparison.covered.psnr;
    }
    stp_image_destroy(&image);
}

static void print_row(const struct axis_judging *j)
{
    FILE *file = j->o->table ? fopen(j->o->table, "a") : NULL;
    if (!file)
        return;
    fprintf(file, "| **%s.** %s | ![](images/hard/%s.png) |", j->c->name, j->c->outcome, j->slug);
    for (unsigned merge = 0; merge < MERGES; merge++)
        fprintf(file, j->db[merge] > 200 ? " same |" : " %.0f |", j->db[merge]);
    fprintf(file, " %.2g |\n", j->worst);
    fclose(file);
}

void hard_judge_axis(const struct hard_options *o, struct device *device, const char *family,
                     const struct hard_case *c)
{
    struct axis_judging j = { .o = o, .device = device, .c = c };
    size_t fragile = 0;
    hard_slug(family, c, j.slug);
    c->make(o, &j.s);
    j.orders = orders_make(j.s.scene, &j.s.camera, &j.s.params);
    j.truth = exact_order(&j.s);
    for (unsigned merge = 0; merge < MERGES; merge++)
        for (int raster = 0; raster < 2; raster++) {
            enum stp_path path = raster ? STP_PATH_RASTER : STP_PATH_COMPUTE;
            judge_picture(&j, &j.s.camera, merge, path, ROUNDING);
            if (j.s.truth[0] > 0 && merge < 3) /* sorted by another eye */
                judge_picture(&j, &j.s.twin_camera, merge, path, ASIDE);
        }
    for (size_t i = 0; i < j.orders.pixels; i++)
        fragile += j.orders.fragile[i];
    if (getenv("STP_TEST_VERDICTS"))
        print_message("%s: %zu of %zu fragile\n", c->name, fragile, j.orders.pixels);
    bool few = (double)fragile <= 0.03 * (double)j.orders.pixels + 8;
    print_row(&j);
    stp_image_destroy(&j.truth);
    orders_release(&j.orders);
    stp_scene_destroy(&j.s.scene);
    assert_true(few);
    assert_true(j.worst <= 1);
}
