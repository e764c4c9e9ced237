#include <stipple/result.h>

const char *stp_result_text(enum stp_result result)
{
    switch (result) {
    case STP_OK:
        return "success";
    case STP_ERROR_ARGUMENT:
        return "an argument is out of range";
    case STP_ERROR_MEMORY:
        return "out of memory";
    case STP_ERROR_IO:
        return "reading or writing failed";
    case STP_ERROR_FORMAT:
        return "damaged file or unknown format";
    case STP_ERROR_NO_POINTS:
        return "no points";
    case STP_ERROR_NO_DEVICE:
        return "no Vulkan device";
    case STP_ERROR_DEVICE:
        return "a Vulkan call failed";
    case STP_ERROR_DEVICE_MEMORY:
        return "out of device memory";
    case STP_ERROR_FEATURE:
        return "a required feature is missing";
    case STP_ERROR_VALIDATION:
        return "a validation layer reported an error";
    }
    return "unknown result";
}

const char *stp_version(void)
{
    return STP_VERSION;
}
