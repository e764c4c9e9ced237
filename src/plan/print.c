/* The plan in words. */
#include "plan/plan.h"

#include <stdio.h>
#include <stdlib.h>

static const char *const format_names[] = { "buffer",        "R32G32_UINT",
                                            "R32G32_SFLOAT", "R32G32B32A32_SFLOAT",
                                            "D32_SFLOAT",    "R32G32B32A32_UINT",
                                            "texels",        "texels",
                                            "texels",        "texels" };
static const char *const lifetime_names[] = { "scene", "transient", "output" };

static const char *const constant_names[PLAN_CONSTANTS] = {
    [PLAN_GROUPS] = "groups",
    [PLAN_VORONOI] = "voronoi",
    [PLAN_PACKED] = "packed",
    [PLAN_GAUSS] = "gauss",
    [PLAN_TWO_SIDED] = "two_sided",
    [PLAN_CULL_BACK] = "cull_back",
    [PLAN_FLOOR] = "floor",
    [PLAN_ORTHOGRAPHIC] = "orthographic",
    [PLAN_HAS_COLOR] = "color",
    [PLAN_HAS_OBJECTS] = "objects",
    [PLAN_HAS_UNKNOWN] = "unknown_normals",
    [PLAN_HEAD_LIGHT] = "head_light",
    [PLAN_LOCAL_VIEWER] = "local_viewer",
    [PLAN_BACKGROUND] = "background",
    [PLAN_AOVS] = "aovs",
    [PLAN_SQUARINGS] = "squarings",
    [PLAN_REPAIR] = "repair",
    [PLAN_KEY_IDS] = "slot_ids",
    [PLAN_ATOMIC64] = "atomic64",
    [PLAN_LAYERED] = "layered",
    [PLAN_FLOAT64] = "float64",
    [PLAN_SAMPLE_GRID] = "sample_grid",
    [PLAN_LANES] = "lanes",
    [PLAN_AXIS_WALKS] = "axis_walks",
    [PLAN_AXIS_CUT] = "axis_cut",
    [PLAN_UNLIT] = "unlit",
    [PLAN_AXIS_WALK] = "axis_walk",
    [PLAN_AXIS_PART] = "axis_part",
    [PLAN_OPACITY] = "opacity",
    [PLAN_MIXED] = "mixed",
    [PLAN_OPTICS] = "optics",
    [PLAN_HOST_DEPTH] = "host_depth",
    [PLAN_DEEP] = "deep",
    [PLAN_PHONG] = "phong",
    [PLAN_SHADE] = "shade",
    [PLAN_LIGHT_CUBE] = "light_cube",
    [PLAN_AXIS_SHAPE] = "axis_shape",
    [PLAN_CULL_CLUSTERS] = "cull_clusters",
    [PLAN_RIM_FAR] = "rim_far",
    [PLAN_CUTS] = "cuts",
    [PLAN_BINS] = "bins",
    [PLAN_COLOR_CODES] = "color_codes",
};

static void print_resources(FILE *out, const struct stp_plan *plan)
{
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        fprintf(out, "  %-12s %-10s %-20s", r->name, lifetime_names[r->lifetime],
                format_names[r->format]);
        if (r->format != PLAN_BUFFER)
            fprintf(out, " %u x %u x %u", r->width, r->height, r->layers);
        fprintf(out, " %llu bytes\n", (unsigned long long)r->bytes);
    }
}

static void print_accesses(FILE *out, const struct stp_plan *plan, const struct plan_pass *pass,
                           unsigned kind, const char *word)
{
    bool first = true;
    for (unsigned i = 0; i < pass->access_count; i++) {
        if (!(pass->access[i].kind & kind))
            continue;
        fprintf(out, "%s%s", first ? word : ", ", plan->resource[pass->access[i].resource].name);
        first = false;
    }
}

static void print_passes(FILE *out, const struct stp_plan *plan)
{
    static const char *const kinds[] = { "fill", "reset",    "dispatch", "dispatch*",
                                         "draw", "exchange", "copy" };
    bool repeats = plan_samples(plan) > 1;
    for (uint32_t i = 0; i < plan->pass_count; i++) {
        if (repeats && i == plan->repeat_first)
            fprintf(out, " for each of %u samples:\n", plan_samples(plan));
        if (plan->chunk_count && i == plan->chunk_first)
            fprintf(out, " for each chunk of points:\n");
        if (plan->chunk_count && plan->again_end && i == plan->again_first)
            fprintf(out, " for each chunk again:\n");
        if (plan->chunk_count && (i == plan->chunk_end || i == plan->again_end))
            fprintf(out, " then:\n");
        if ((repeats || plan->loop_first) && i == plan->repeat_end)
            fprintf(out, " then:\n");
        if (plan->loop_first && i == plan->loop_first)
            fprintf(out, " while rays have layers left:\n");
        const struct plan_pass *pass = &plan->pass[i];
        fprintf(out, "  %-9s %-20s", kinds[pass->kind], pass->name);
        print_accesses(out, plan, pass, PLAN_READ, " reads ");
        print_accesses(out, plan, pass, PLAN_WRITE, "; writes ");
        fputc('\n', out);
    }
}

static void print_lists(FILE *out, const struct stp_plan *plan)
{
    static const char *const merges[] = { "auto", "blend", "clip", "single", "sort" };
    const struct axis_lists *lists = &plan->axis;
    fprintf(out, "lists: %s", merges[lists->merge]);
    if (lists->merge == STP_AXIS_BLEND)
        fprintf(out, ", h %.4g", lists->h);
    fprintf(out, ", %zu kernels seen, %zu splats drawn\n", lists->visible, lists->count);
    for (unsigned i = 0; i < lists->walk_count; i++)
        fprintf(out, "  rays along %c%c: %u splats, far to near\n",
                lists->walk[i].backwards ? '-' : '+', "xyz"[lists->walk[i].axis],
                lists -> walk[i].count);
}

static void print(FILE *out, const struct stp_plan *plan)
{
    fprintf(out, "method %s, path %s, %zu splats, %u x %u pixels\n", stp_method_name(plan->method),
            stp_path_name(plan->path), plan->facts.splats, plan->camera.width, plan->camera.height);
    if (plan->transparency != STP_TRANSPARENCY_AUTO)
        fprintf(out, "transparency %s\n", stp_transparency_name(plan->transparency));
    if (plan_samples(plan) > 1)
        fprintf(out, "samples: %u a pixel, %u x %u\n", plan_samples(plan),
                plan->constant[PLAN_SAMPLE_GRID], plan->constant[PLAN_SAMPLE_GRID]);
    if (plan->share.count)
        fprintf(out, "process %u of %u, %llu splats here\n", plan->share.rank, plan->share.count,
                (unsigned long long)plan->share.splats);
    fprintf(out, "why: %s\n", plan->why);
    if (plan->method == STP_METHOD_REFERENCE)
        return;
    if (plan->method == STP_METHOD_AXIS)
        print_lists(out, plan);
    fprintf(out, "constants:");
    for (int i = 0; i < PLAN_CONSTANTS; i++)
        if (plan->constant[i])
            fprintf(out, " %s=%u", constant_names[i], plan->constant[i]);
    fprintf(out, "\ntiles: %u of at most %u x %u\n", plan->tile_count, plan->tile_width,
            plan->tile_height);
    if (plan->chunk_count)
        fprintf(out, "chunks: %u of at most %llu points\n", plan->chunk_count,
                (unsigned long long)plan_chunk_points(plan));
    fprintf(out, "resources: scene %llu, transient %llu, output %llu bytes\n",
            (unsigned long long)plan_bytes(plan, PLAN_SCENE),
            (unsigned long long)plan_bytes(plan, PLAN_TRANSIENT),
            (unsigned long long)plan_bytes(plan, PLAN_OUTPUT));
    print_resources(out, plan);
    fprintf(out, "passes (a * is dispatched indirectly):\n");
    print_passes(out, plan);
}

char *stp_plan_print(const struct stp_plan *plan)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    print(out, plan);
    if (fclose(out) == 0)
        return text;
    free(text);
    return NULL;
}
