#include "study/study.h"

#include <string.h>

static const double overlaps[] = { 0.4, 0.6, 0.8, 0.85, 1.0 };
static const double quick_overlaps[] = { 0.4, 0.6, 0.8, 1.0 };
#define COUNT(array) (unsigned)(sizeof array / sizeof *array)

struct list {
    struct study_config *config;
    unsigned count;
};

static void add(struct list *list, struct study_config config)
{
    if (list->count < STUDY_MAX_CONFIGS)
        list->config[list->count++] = config;
}

static void add_exact(struct list *list, bool quick, enum stp_transparency transparency)
{
    struct study_config config = { .method = STP_METHOD_EXACT,
                                   .path = STP_PATH_COMPUTE,
                                   .voronoi = STP_VORONOI_OFF,
                                   .epsilon_scale = 1,
                                   .transparency = transparency };
    const enum stp_payload payload[] = { STP_PAYLOAD_PACKED, STP_PAYLOAD_ID };
    for (unsigned i = 0; i < COUNT(payload); i++) {
        config.payload = payload[i];
        add(list, config);
    }
    const double scale[] = { 0.5, 2 };
    config.payload = STP_PAYLOAD_PACKED;
    for (unsigned i = 0; i < COUNT(scale) && !quick; i++) {
        config.epsilon_scale = scale[i];
        add(list, config);
    }
}

static void add_twopass(struct list *list)
{
    static const enum stp_path paths[] = { STP_PATH_COMPUTE, STP_PATH_RASTER };
    for (unsigned i = 0; i < COUNT(paths); i++)
        add(list, (struct study_config){ .method = STP_METHOD_TWO_PASS,
                                         .path = paths[i],
                                         .voronoi = STP_VORONOI_OFF,
                                         .epsilon_scale = 1 });
}

static void add_pyramid(struct list *list)
{
    add(list, (struct study_config){ .method = STP_METHOD_PYRAMID,
                                     .path = STP_PATH_COMPUTE,
                                     .voronoi = STP_VORONOI_OFF,
                                     .epsilon_scale = 1 });
}

static void add_deferred(struct list *list, bool quick, double overlap)
{
    static const struct {
        enum stp_path path;
        enum stp_payload payload;
        enum stp_voronoi voronoi;
    } all[] = {
        { STP_PATH_COMPUTE, STP_PAYLOAD_PACKED, STP_VORONOI_OFF },
        { STP_PATH_COMPUTE, STP_PAYLOAD_PACKED, STP_VORONOI_SLAB },
        { STP_PATH_COMPUTE, STP_PAYLOAD_ID, STP_VORONOI_OFF },
        { STP_PATH_COMPUTE, STP_PAYLOAD_ID, STP_VORONOI_SLAB },
        { STP_PATH_COMPUTE, STP_PAYLOAD_ID, STP_VORONOI_EXACT },
        { STP_PATH_RASTER, STP_PAYLOAD_PACKED, STP_VORONOI_OFF },
        { STP_PATH_RASTER, STP_PAYLOAD_PACKED, STP_VORONOI_SLAB },
        { STP_PATH_RASTER, STP_PAYLOAD_ID, STP_VORONOI_OFF },
        { STP_PATH_RASTER, STP_PAYLOAD_ID, STP_VORONOI_SLAB },
    }, brief[] = {
        { STP_PATH_COMPUTE, STP_PAYLOAD_AUTO, STP_VORONOI_SLAB },
        { STP_PATH_RASTER, STP_PAYLOAD_AUTO, STP_VORONOI_SLAB },
    };
    unsigned count = quick ? COUNT(brief) : COUNT(all);
    if (quick && overlap > 0.4 && overlap < 1)
        count = 1; /* by the rasteriser the ends suffice */
    for (unsigned i = 0; i < count; i++)
        add(list, (struct study_config){ .method = STP_METHOD_DEFERRED,
                                         .path = quick ? brief[i].path : all[i].path,
                                         .payload = quick ? brief[i].payload : all[i].payload,
                                         .voronoi = quick ? brief[i].voronoi : all[i].voronoi,
                                         .overlap = overlap,
                                         .epsilon_scale = 1 });
}

static void add_opaque(struct list *list, bool quick)
{
    const double *overlap = quick ? quick_overlaps : overlaps;
    unsigned count = quick ? COUNT(quick_overlaps) : COUNT(overlaps);
    add_exact(list, quick, STP_TRANSPARENCY_AUTO);
    add_twopass(list);
    add_pyramid(list);
    for (unsigned i = 0; i < count; i++)
        add_deferred(list, quick, overlap[i]);
}

static void add_layered(struct list *list, enum stp_method method, enum stp_path path,
                        enum stp_transparency transparency, unsigned layers)
{
    add(list, (struct study_config){ .method = method,
                                     .path = path,
                                     .epsilon_scale = 1,
                                     .transparency = transparency,
                                     .peel_layers = layers });
}

/* Peeling at every depth is the baseline's own frontier. */
static void add_transparent(struct list *list, bool quick)
{
    static const unsigned layers[] = { 1, 2, 4, 8, 16 }, few[] = { 2, 8 };
    static const enum stp_path paths[] = { STP_PATH_COMPUTE, STP_PATH_RASTER };
    const unsigned *layer = quick ? few : layers, count = quick ? COUNT(few) : COUNT(layers);
    add_exact(list, true, STP_TRANSPARENCY_EXACT);
    add_layered(list, STP_METHOD_DEFERRED, STP_PATH_RASTER, STP_TRANSPARENCY_FAST, 0);
    add_layered(list, STP_METHOD_DEFERRED, STP_PATH_RASTER, STP_TRANSPARENCY_NEAREST, 0);
    for (unsigned p = 0; p < COUNT(paths); p++)
        for (unsigned i = 0; i < count; i++)
            add_layered(list, STP_METHOD_TWO_PASS, paths[p], STP_TRANSPARENCY_PEEL, layer[i]);
}

static void add_merge(struct list *list, enum stp_axis_merge merge, double h)
{
    static const enum stp_path paths[] = { STP_PATH_COMPUTE, STP_PATH_RASTER };
    for (unsigned i = 0; i < COUNT(paths); i++)
        add(list, (struct study_config){ .method = STP_METHOD_AXIS,
                                         .path = paths[i],
                                         .epsilon_scale = 1,
                                         .merge = merge,
                                         .axis_h = h });
}

static void add_volume(struct list *list, bool quick)
{
    static const double overlap[] = { 0.85, -1, 0.5, 0.95 }; /* negative: 0 */
    add_merge(list, STP_AXIS_SINGLE, 0);
    add_merge(list, STP_AXIS_CLIP, 0);
    add_merge(list, STP_AXIS_SORT, 0);
    for (unsigned i = 0; i < (quick ? 1 : COUNT(overlap)); i++)
        add_merge(list, STP_AXIS_BLEND, overlap[i]);
}

unsigned study_configs(const struct stp_facts *facts, bool quick,
                       struct study_config configs[STUDY_MAX_CONFIGS])
{
    struct list list = { configs, 0 };
    if (facts->volume.dims[0] || facts->range.frames)
        add_volume(&list, quick);
    else if (facts->transparent)
        add_transparent(&list, quick);
    else
        add_opaque(&list, quick);
    return list.count;
}

static const char *payload_word(enum stp_payload payload)
{
    static const char *const words[] = { "", "id", "packed" };
    return words[payload];
}

static const char *voronoi_word(enum stp_voronoi voronoi)
{
    static const char *const words[] = { "", "off", "slab", "exact" };
    return words[voronoi];
}

static const char *merge_word(enum stp_axis_merge merge)
{
    static const char *const words[] = { "auto", "blend", "clip", "single", "sort" };
    return words[merge];
}

static bool is_baseline(const struct study_config *config)
{
    if (config->method == STP_METHOD_AXIS)
        return config->merge == STP_AXIS_SINGLE;
    if (config->transparency != STP_TRANSPARENCY_AUTO)
        return config->peel_layers == STP_DEFAULT_PEEL_LAYERS;
    return config->method == STP_METHOD_TWO_PASS;
}

void study_describe(const struct study_config *config, struct report_row *row)
{
    row->method = stp_method_name(config->method);
    row->path = stp_path_name(config->path);
    row->payload = payload_word(config->payload);
    row->voronoi = config->overlap > 0 ? voronoi_word(config->voronoi) : "";
    row->overlap_asked = config->overlap;
    row->epsilon_scale = config->epsilon_scale;
    row->transparency = config->transparency != STP_TRANSPARENCY_AUTO
                            ? stp_transparency_name(config->transparency)
                            : NULL;
    row->peel_layers = config->peel_layers;
    row->merge = config->method == STP_METHOD_AXIS ? merge_word(config->merge) : NULL;
    row->axis_h = config->axis_h > 0 ? config->axis_h : 0;
    row->is_baseline = is_baseline(config);
}

const char *study_mismatch(const struct study_config *config, const struct stp_plan *plan)
{
    struct stp_plan_summary summary;
    stp_plan_summarize(plan, &summary);
    if (config->payload == STP_PAYLOAD_PACKED && summary.payload != STP_PAYLOAD_PACKED)
        return "packed keys cannot hold this scene (colours, several objects or a depth range of "
               "too many epsilons); keys with ids are measured";
    bool opaque =
        config->transparency == STP_TRANSPARENCY_AUTO && config->method != STP_METHOD_AXIS;
    if (opaque && summary.voronoi != config->voronoi)
        return "the depth range over epsilon is beyond the slabs that a key can hold";
    if (summary.method != config->method || summary.path != config->path)
        return "the plan takes another method or path here";
    return NULL;
}
