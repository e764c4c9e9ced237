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

static void add_exact(struct list *list, bool quick)
{
    struct study_config config = {
        STP_METHOD_EXACT, STP_PATH_COMPUTE, STP_PAYLOAD_PACKED, STP_VORONOI_OFF, 0, 1
    };
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
    add(list, (struct study_config){ STP_METHOD_TWO_PASS, STP_PATH_COMPUTE, STP_PAYLOAD_AUTO,
                                     STP_VORONOI_OFF, 0, 1 });
    add(list, (struct study_config){ STP_METHOD_TWO_PASS, STP_PATH_RASTER, STP_PAYLOAD_AUTO,
                                     STP_VORONOI_OFF, 0, 1 });
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
        add(list, (struct study_config){ STP_METHOD_DEFERRED, quick ? brief[i].path : all[i].path,
                                         quick ? brief[i].payload : all[i].payload,
                                         quick ? brief[i].voronoi : all[i].voronoi, overlap, 1 });
}

unsigned study_configs(bool quick, struct study_config configs[STUDY_MAX_CONFIGS])
{
    struct list list = { configs, 0 };
    const double *overlap = quick ? quick_overlaps : overlaps;
    unsigned count = quick ? COUNT(quick_overlaps) : COUNT(overlaps);
    add_exact(&list, quick);
    add_twopass(&list);
    for (unsigned i = 0; i < count; i++)
        add_deferred(&list, quick, overlap[i]);
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

void study_describe(const struct study_config *config, struct report_row *row)
{
    row->method = stp_method_name(config->method);
    row->path = stp_path_name(config->path);
    row->payload = payload_word(config->payload);
    row->voronoi = config->method == STP_METHOD_DEFERRED ? voronoi_word(config->voronoi) : "";
    row->overlap_asked = config->overlap;
    row->epsilon_scale = config->epsilon_scale;
}

const char *study_mismatch(const struct study_config *config, const struct stp_plan *plan)
{
    struct stp_plan_summary summary;
    stp_plan_summarize(plan, &summary);
    if (config->payload == STP_PAYLOAD_PACKED && summary.payload != STP_PAYLOAD_PACKED)
        return "packed keys cannot hold this scene (colours, several objects or a depth range of "
               "too many epsilons); keys with ids are measured";
    if (summary.voronoi != config->voronoi)
        return "the depth range over epsilon is beyond the slabs that a key can hold";
    if (summary.method != config->method || summary.path != config->path)
        return "the plan takes another method or path here";
    return NULL;
}
