/* The program: every case of a family, or of all; --help says what varies. */
#include "hard.h"

static const struct hard_family *const families[] = {
    &hard_coordinates, &hard_views,   &hard_splats,   &hard_normals,   &hard_crowds,
    &hard_sheets,      &hard_colors,  &hard_pictures, &hard_bits,      &hard_devices,
    &hard_breaks,      &hard_samples, &hard_layers,   &hard_axis,      &hard_axis_surface,
    &hard_ellipses,    &hard_phong,   &hard_fits,     &hard_fits_flat,
};
#define FAMILIES (sizeof families / sizeof *families)

/* What one test of cmocka's needs. */
struct job {
    const struct hard_options *o;
    struct device *device;
    const struct hard_family *family;
    const struct hard_case *c;
    void (*judge)(const struct hard_options *o, struct device *device, const char *family,
                  const struct hard_case *c);
};

static const char usage[] =
    "usage: hard [--family NAME] [--case PART] [--seed N] [--size WxH] [--look AZ,EL]\n"
    "            [--points N] [--table FILE] [--pictures DIR] [--write DIR]\n"
    "Renders the hard cases every way and judges them; the family pyramid is the other\n"
    "families' points by that method, but for those of ellipses. Defaults: all, seed 1, 112x84,\n"
    "seen from 30,20 degrees, surfaces of 1500 points. N is from 1 on, of points from 200, W and\n"
    "H from 16, EL within 79 degrees. --table appends Markdown rows,\n"
    "--pictures writes a PNG a case, --write the splats, the camera and every EXR.\n";

static void run_job(void **state)
{
    struct job *job = *state;
    if (!job->c->run) {
        job->judge(job->o, job->device, job->family->name, job->c);
        return;
    }
    job->c->run(job->o, job->device);
    if (job->c->outcome[0])
        hard_say(job->o, job->family->name, job->c);
}

/* `name` is the family's own, or that of the pyramid's. */
static bool wanted(const struct hard_options *o, const char *name, const struct hard_case *c)
{
    return (!o->family || strcmp(o->family, name) == 0) && (!o->only || strstr(c->name, o->only));
}

static bool parse_text(struct hard_options *o, const char *key, const char *value)
{
    const struct {
        const char *key;
        const char **text;
    } texts[] = { { "--family", &o->family },
                  { "--case", &o->only },
                  { "--table", &o->table },
                  { "--pictures", &o->pictures },
                  { "--write", &o->write } };
    for (unsigned i = 0; i < sizeof texts / sizeof *texts; i++)
        if (strcmp(key, texts[i].key) == 0) {
            *texts[i].text = value;
            return true;
        }
    return false;
}

static bool parse_number(struct hard_options *o, const char *key, const char *value)
{
    double az, el;
    o->varied = true;
    if (strcmp(key, "--seed") == 0)
        return sscanf(value, "%u", &o->seed) == 1 && o->seed > 0;
    if (strcmp(key, "--points") == 0)
        return sscanf(value, "%zu", &o->points) == 1 && o->points >= 200;
    if (strcmp(key, "--size") == 0)
        return sscanf(value, "%ux%u", &o->width, &o->height) == 2 && o->width >= 16 &&
               o->height >= 16;
    if (strcmp(key, "--look") != 0 || sscanf(value, "%lf,%lf", &az, &el) != 2)
        return false;
    o->turn = az * M_PI / 180;
    o->rise = el * M_PI / 180;
    return fabs(el) < 80;
}

#define MOST_JOBS 192
struct jobs {
    unsigned count;
    struct job job[MOST_JOBS];
    struct CMUnitTest test[MOST_JOBS];
};

static void add_job(struct jobs *jobs, const struct job *job)
{
    assert_true(jobs->count < MOST_JOBS);
    jobs->job[jobs->count] = *job;
    jobs->test[jobs->count] = (struct CMUnitTest){ .name = job->c->name,
                                                   .test_func = run_job,
                                                   .initial_state = &jobs->job[jobs->count] };
    jobs->count++;
}

static void list_jobs(const struct hard_options *o, struct device *device, struct jobs *jobs)
{
    for (unsigned f = 0; f < FAMILIES; f++)
        for (unsigned i = 0; i < families[f]->count; i++) {
            bool lists = families[f] == &hard_axis || families[f] == &hard_axis_surface;
            bool bent = families[f] == &hard_ellipses || families[f] == &hard_phong ||
                        families[f] == &hard_fits || families[f] == &hard_fits_flat;
            struct job job = { o, device, families[f], &families[f]->cases[i],
                               lists ? hard_judge_axis : hard_judge };
            if (wanted(o, families[f]->name, job.c))
                add_job(jobs, &job);
            job.judge = hard_judge_pyramid;
            if (!lists && !bent && !job.c->run && wanted(o, "pyramid", job.c))
                add_job(jobs, &job);
        }
}

int main(int argc, char **argv)
{
    struct hard_options o = {
        .seed = 1, .width = 112, .height = 84, .turn = M_PI / 6, .rise = M_PI / 9, .points = 1500
    };
    for (int i = 1; i < argc; i += 2)
        if (i + 1 == argc ||
            !(parse_text(&o, argv[i], argv[i + 1]) || parse_number(&o, argv[i], argv[i + 1]))) {
            fputs(usage, stderr);
            return 2;
        }
    struct device device;
    struct jobs jobs = { 0 };
    list_jobs(&o, &device, &jobs);
    if (jobs.count == 0) {
        fputs("hard: no such case\n", stderr);
        return 2;
    }
    device_open(&device, 0);
    int failed =
        _cmocka_run_group_tests(o.family ? o.family : "hard", jobs.test, jobs.count, NULL, NULL);
    device_close(&device);
    return failed != 0;
}
