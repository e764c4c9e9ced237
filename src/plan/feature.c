#include <stipple/plan.h>

const char *stp_feature_name(enum stp_feature feature)
{
    switch (feature) {
    case STP_FEATURE_INT64_ATOMICS:
        return "int64-atomics";
    case STP_FEATURE_VERTEX_LAYER:
        return "vertex-layer";
    case STP_FEATURE_FLOAT32_BLEND:
        return "float32-blend";
    case STP_FEATURE_INT64:
        return "int64";
    case STP_FEATURE_FLOAT64:
        return "float64";
    case STP_FEATURE_STORAGE_FORMATS:
        return "storage-formats";
    case STP_FEATURE_SHARED_MEMORY:
        return "shared-memory";
    case STP_FEATURE_TEXEL_BUFFERS:
        return "texel-buffers";
    case STP_FEATURE_SUBGROUP_SHUFFLE:
        return "subgroup-shuffle";
    case STP_FEATURE_INDEPENDENT_BLEND:
        return "independent-blend";
    }
    return NULL;
}
