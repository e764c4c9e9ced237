/* ZP Table 1 for the given files, as Markdown: K / largest degree / average degree for each c and
 * relaxation, and the time of the grouping at c = 1. table1 FILE... */
#include <stipple/stipple.h>

#include <stdio.h>
#include <string.h>

static const double overlaps[] = { 1.0, 0.8, 0.6, 0.4 };
static const struct {
    const char *name;
    unsigned relax;
} rows[] = {
    { "none", STP_RELAX_NONE },
    { "opposed", STP_RELAX_OPPOSED },
    { "all", STP_RELAX_OPPOSED | STP_RELAX_COPLANAR },
};

static enum stp_result print_row(struct stp_scene *scene, const char *path, unsigned row)
{
    const struct stp_facts *facts = stp_scene_facts(scene);
    const char *slash = strrchr(path, '/');
    double milliseconds = 0;
    printf("| %s | %zu | %s |", slash ? slash + 1 : path, facts->splats, rows[row].name);
    for (unsigned c = 0; c < 4; c++) {
        struct stp_group_params params = { .overlap = overlaps[c], .relax = rows[row].relax };
        enum stp_result result = stp_scene_group(NULL, scene, &params);
        if (result != STP_OK)
            return result;
        const struct stp_grouping *g = &facts->grouping;
        printf(" %u / %u / %.1f |", g->groups, g->max_degree, g->avg_degree);
        milliseconds = c ? milliseconds : g->milliseconds;
    }
    printf(" %.0f ms, %.1f M/s |\n", milliseconds, (double)facts->splats / milliseconds / 1e3);
    return STP_OK;
}

static enum stp_result print_file(const char *path)
{
    struct stp_scene *scene = NULL;
    enum stp_result result = stp_scene_load(NULL, path, NULL, &scene);
    if (result == STP_OK)
        result = stp_scene_prepare(NULL, scene, NULL);
    for (unsigned row = 0; result == STP_OK && row < sizeof rows / sizeof *rows; row++)
        result = print_row(scene, path, row);
    stp_scene_destroy(&scene);
    return result;
}

int main(int argc, char **argv)
{
    int failed = 0;
    if (argc < 2) {
        fprintf(stderr, "usage: table1 FILE...\n");
        return 2;
    }
    printf("| model | splats | relaxation | c = 1.0 | c = 0.8 | c = 0.6 | c = 0.4 | c = 1.0 takes "
           "|\n|---|---|---|---|---|---|---|---|\n");
    for (int i = 1; i < argc; i++)
        failed |= print_file(argv[i]) != STP_OK;
    return failed;
}
