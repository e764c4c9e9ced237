/* stipple devices: what Vulkan offers here, what each device lacks, and a profile for plans. */
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static const char *processor_text(const struct stp_limits *limits)
{
    return limits->processor == STP_PROCESSOR_CPU ? "software" : "GPU";
}

static void print_features(const struct stp_limits *limits)
{
    bool any = false;
    for (unsigned bit = 1; stp_feature_name((enum stp_feature)bit); bit *= 2) {
        if (limits->features & bit)
            printf("%s%s", any ? ", " : "", stp_feature_name((enum stp_feature)bit));
        any = any || (limits->features & bit);
    }
    printf("%s\n", any ? "" : "none");
}

static void print_device(const struct stp_device_info *device)
{
    const struct stp_limits *limits = &device->limits;
    printf("%s\n", limits->device);
    printf("  kind      %s%s\n", processor_text(limits), device->usable ? "" : ", not usable");
    printf("  driver    %s, Vulkan %s\n", limits->driver, device->api_version);
    printf("  memory    %.0f MiB, %.0f MiB in one buffer\n", (double)limits->heap_bytes / 1048576,
           (double)limits->max_allocation / 1048576);
    printf("  images    %u x %u, %u layers\n", limits->max_image_size, limits->max_image_size,
           limits->max_image_layers);
    printf("  has       ");
    print_features(limits);
    printf("  lacks     %s\n", device->lacks[0] ? device->lacks : "nothing");
}

/* The profile that `stipple plan --limits` reads, and what was found out beside it. */
static int print_profile(struct console *console, const struct stp_device_info *device)
{
    char *profile = stp_limits_print(&device->limits);
    struct json_out building = { 0 }, *out = &building;
    cJSON *json = json_begin(out, profile ? cJSON_Parse(profile) : NULL);
    json_text(out, json, "api_version", device->api_version);
    json_bool(out, json, "usable", device->usable);
    json_text(out, json, "lacks", device->lacks);
    int status = json_print(console, out, json);
    cJSON_Delete(json);
    free(profile);
    return status;
}

/* Keeps the devices whose name holds `part`, in order; returns how many. */
static unsigned select_devices(struct stp_device_info *devices, unsigned count, const char *part)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < count; i++)
        if (!part || strcasestr(devices[i].limits.device, part))
            devices[kept++] = devices[i];
    return kept;
}

static struct stp_device_info *first_usable(struct stp_device_info *devices, unsigned count)
{
    for (unsigned i = 0; i < count; i++)
        if (devices[i].usable)
            return &devices[i];
    return &devices[0];
}

static int print_devices(const struct stp_device_info *devices, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        if (i)
            putchar('\n');
        print_device(&devices[i]);
    }
    return EXIT_DONE;
}

/* The prices of this device: from the cache, or measured where that is asked for. */
static enum stp_result calibrate(struct console *console, const struct settings *settings,
                                 struct stp_device_info *device)
{
    struct stp_context_params params = { .device = device->limits.device };
    struct stp_calibrate_params how = { .again = settings->calibrate,
                                        .only_cached = !settings->calibrate };
    struct stp_context *context = NULL;
    if (!device->usable)
        return STP_OK;
    enum stp_result result = stp_context_create(&console->env, &params, &context);
    if (result == STP_OK)
        result = stp_calibrate(&console->env, context, &how);
    if (result == STP_OK)
        device->limits.calibration = stp_context_limits(context)->calibration;
    stp_context_destroy(&context);
    return result;
}

static int show(struct console *console, const struct settings *settings,
                struct stp_device_info *devices, unsigned count)
{
    struct stp_device_info *first = first_usable(devices, count);
    if ((settings->json || settings->calibrate) && calibrate(console, settings, first) != STP_OK)
        return EXIT_FAILED;
    return settings->json ? print_profile(console, first) : print_devices(devices, count);
}

/* All devices, to be freed; one that comes between the calls is left out. NULL: logged. */
static struct stp_device_info *find_devices(struct console *console, unsigned *count)
{
    unsigned capacity = 0, found = 0;
    if (stp_devices(&console->env, NULL, 0, &capacity) != STP_OK)
        return NULL;
    struct stp_device_info *devices = calloc(capacity ? capacity : 1, sizeof *devices);
    if (!devices)
        console_error(console, "out of memory");
    else if (stp_devices(&console->env, devices, capacity, &found) == STP_OK) {
        *count = found < capacity ? found : capacity;
        return devices;
    }
    free(devices);
    return NULL;
}

int run_devices(struct settings *settings)
{
    struct console console;
    const char *part = settings->context.device;
    unsigned count = 0;
    int status = EXIT_FAILED;
    console_open(&console, settings);
    struct stp_device_info *devices = find_devices(&console, &count);
    if (devices)
        count = select_devices(devices, count, part);
    if (devices && count == 0)
        console_error(&console,
                      part ? "no Vulkan device is called \"%s\"; see stipple devices"
                           : "no Vulkan device; mesa-vulkan-drivers brings one that needs no GPU",
                      part);
    else if (devices)
        status = show(&console, settings, devices, count);
    console_close(&console);
    free(devices);
    return status;
}
