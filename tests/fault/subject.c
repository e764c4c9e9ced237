#include "subject.h"

#include <dlfcn.h>

#define WIDTH  40
#define HEIGHT 24

struct fault_controls find_faults(void)
{
    struct fault_controls fault;
    void *loader = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    assert_non_null(loader);
    fault.arm = (fault_arm_fn *)dlsym(loader, "fault_arm");
    fault.discrete = (fault_discrete_fn *)dlsym(loader, "fault_discrete");
    fault.crowd = (fault_crowd_fn *)dlsym(loader, "fault_crowd");
    fault.read = (fault_read_fn *)dlsym(loader, "fault_read");
    if (!fault.arm || !fault.discrete || !fault.read)
        fail_msg("libvulkan.so.1 is the real loader: run under meson test");
    return fault;
}

static void keep_line(void *user, enum stp_log_level level, const char *line)
{
    struct device *device = user;
    device->lines++;
    snprintf(device->last, sizeof device->last, "%s", line);
}

void device_silent(struct device *device)
{
    *device = (struct device){ .env = { .threads = 1, .log = keep_line, .user = device } };
}

void no_misuse(const struct fault_controls *fault, const char *what, unsigned live)
{
    struct fault_state seen = fault->read();
    if (seen.misuse[0])
        fail_msg("%s, call %lu (%s): %s", what, seen.calls, seen.injected, seen.misuse);
    if (seen.live != live)
        fail_msg("%s, %s failing: %u objects are alive, not %u", what, seen.injected, seen.live,
                 live);
}

enum stp_result subject_render(struct subject *s, struct stp_image **image)
{
    s->device.lines = 0;
    enum stp_result result =
        stp_render(&s->device.env, s->device.context, s->scene, s->plan, s->repeat, image, NULL);
    subject_rendered(s);
    return result;
}

void subject_rendered(struct subject *s)
{
    s->made = s->device.context->kept != NULL;
    if (!s->warm)
        gpu_trim(s->device.context);
}

void subject_warm(struct subject *s)
{
    struct stp_image *image = NULL;
    s->warm = true;
    s->fault.arm(0, 0, false);
    assert_int_equal(subject_render(s, &image), STP_OK);
    expect_same_bits(image, s->image, s->what);
    stp_image_destroy(&image);
    s->live = s->fault.read().live;
}

void subject_open(struct subject *s, const struct stp_scene *scene, const struct way *way,
                  unsigned repeat)
{
    struct stp_context_params params = { 0 };
    struct stp_camera camera = hard_view(0, WIDTH, HEIGHT);
    struct stp_render_params render_params = way->params;
    if (way->params.method != STP_METHOD_AXIS) /* which has neither */
        render_params.aovs = STP_AOV_ID | STP_AOV_ALBEDO;
    *s = (struct subject){
        .fault = find_faults(), .scene = scene, .what = way->name, .repeat = repeat
    };
    device_silent(&s->device);
    s->fault.arm(0, 0, false);
    assert_int_equal(stp_context_create(NULL, &params, &s->device.context), STP_OK);
    s->live = s->fault.read().live;
    assert_int_equal(device_plan(&s->device, scene, &camera, &render_params, &s->plan), STP_OK);
    assert_int_equal(subject_render(s, &s->image), STP_OK);
    no_misuse(&s->fault, s->what, s->live);
}

void subject_close(struct subject *s)
{
    stp_image_destroy(&s->image);
    stp_plan_destroy(&s->plan);
    stp_context_destroy(&s->device.context);
    no_misuse(&s->fault, s->what, 0);
}

struct stp_scene *small_scene(void)
{
    struct stp_scene *scene = scene_random(61, 6, 0.1);
    scene_own_groups(scene);
    return scene;
}
