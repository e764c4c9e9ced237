/* stipple devices: what Vulkan offers here, what each device lacks, and a profile for plans. */
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

#define MAX_DEVICES 16

static const char *processor_text(const struct stp_limits *limits)
{
    return limits->processor == 1 ? "software" : "GPU";
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
    const struct stp_limits *limits = &device->limits;
    struct json_out building = { 0 }, *out = &building;
    cJSON *json = json_begin(out, cJSON_CreateObject());
    json_text(out, json, "device", limits->device);
    json_text(out, json, "driver", limits->driver);
    cJSON *features = json_array(out, json, "features");
    for (unsigned bit = 1; stp_feature_name((enum stp_feature)bit); bit *= 2)
        if (limits->features & bit)
            json_text(out, features, NULL, stp_feature_name((enum stp_feature)bit));
    json_number(out, json, "heap_bytes", (double)limits->heap_bytes);
    json_number(out, json, "max_allocation", (double)limits->max_allocation);
    json_number(out, json, "max_image_size", limits->max_image_size);
    json_number(out, json, "max_image_layers", limits->max_image_layers);
    json_number(out, json, "max_workgroups", limits->max_workgroups);
    json_number(out, json, "processor", limits->processor);
    json_text(out, json, "api_version", device->api_version);
    json_bool(out, json, "usable", device->usable);
    json_text(out, json, "lacks", device->lacks);
    int status = json_print(console, out, json);
    cJSON_Delete(json);
    return status;
}

/* Keeps the devices whose name holds `part`, in order; returns how many. */
static unsigned select_devices(struct stp_device_info *devices, unsigned count, const char *part)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < count; i++)
        if (!part || strstr(devices[i].limits.device, part))
            devices[kept++] = devices[i];
    return kept;
}

static const struct stp_device_info *first_usable(const struct stp_device_info *devices,
                                                  unsigned count)
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

int run_devices(struct settings *settings)
{
    struct console console;
    struct stp_device_info *devices = calloc(MAX_DEVICES, sizeof *devices);
    unsigned count = 0;
    int status = EXIT_FAILED;
    console_open(&console, settings);
    if (!devices) {
        console_error(&console, "out of memory");
        console_close(&console);
        return status;
    }
    enum stp_result result = stp_devices(&console.env, devices, MAX_DEVICES, &count);
    const char *part = settings->context.device;
    count = select_devices(devices, count > MAX_DEVICES ? MAX_DEVICES : count, part);
    if (result == STP_OK && count == 0)
        console_error(&console,
                      "no Vulkan device%s%s; mesa-vulkan-drivers brings one that needs no GPU",
                      part ? " whose name holds " : "", part ? part : "");
    else if (result == STP_OK && settings->json)
        status = print_profile(&console, first_usable(devices, count));
    else if (result == STP_OK)
        status = print_devices(devices, count);
    console_close(&console);
    free(devices);
    return status;
}
