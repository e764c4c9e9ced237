/* Every format of a colour target: the float picture, clamped and rounded as the format says, in
 * place of what was there or over it, in the layouts that the host asks for. */
#include "stage.h"

#include <math.h>

static double half(unsigned bits)
{
    unsigned exponent = bits >> 10 & 31, mantissa = bits & 1023;
    double value = exponent ? ldexp(1024 + mantissa, (int)exponent - 25) : ldexp(mantissa, -24);
    return bits >> 15 ? -value : value;
}

/* An unsigned float of five exponent bits. */
static double small_float(unsigned bits, int mantissa_bits)
{
    unsigned one = 1u << mantissa_bits, exponent = bits >> mantissa_bits, rest = bits & (one - 1);
    return exponent ? ldexp(one + rest, (int)exponent - 15 - mantissa_bits)
                    : ldexp(rest, -14 - mantissa_bits);
}

static double linear(double s)
{
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

static double encoded(double l)
{
    return l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055;
}

static void decode_float(const void *texel, double rgba[4])
{
    for (int k = 0; k < 4; k++)
        rgba[k] = (double)((const float *)texel)[k];
}

static void decode_half(const void *texel, double rgba[4])
{
    for (int k = 0; k < 4; k++)
        rgba[k] = half(((const uint16_t *)texel)[k]);
}

static void decode_b10g11r11(const void *texel, double rgba[4])
{
    uint32_t word = *(const uint32_t *)texel;
    rgba[0] = small_float(word & 2047, 6);
    rgba[1] = small_float(word >> 11 & 2047, 6);
    rgba[2] = small_float(word >> 22, 5);
    rgba[3] = NAN; /* it has none */
}

static void decode_rgba8(const void *texel, double rgba[4])
{
    for (int k = 0; k < 4; k++)
        rgba[k] = ((const uint8_t *)texel)[k] / 255.0;
}

static void decode_bgra8(const void *texel, double rgba[4])
{
    const uint8_t *t = texel;
    decode_rgba8((const uint8_t[]){ t[2], t[1], t[0], t[3] }, rgba);
}

static void decode_rgba8_srgb(const void *texel, double rgba[4])
{
    decode_rgba8(texel, rgba);
    for (int k = 0; k < 3; k++)
        rgba[k] = linear(rgba[k]);
}

static void decode_bgra8_srgb(const void *texel, double rgba[4])
{
    decode_bgra8(texel, rgba);
    for (int k = 0; k < 3; k++)
        rgba[k] = linear(rgba[k]);
}

/* `relative` and `absolute`: the step between neighbours, of which a device may take either. */
static const struct target {
    VkFormat format;
    size_t bytes;
    double most, relative, absolute;
    void (*decode)(const void *texel, double rgba[4]);
} targets[] = {
    { VK_FORMAT_R32G32B32A32_SFLOAT, 16, 3.4e38, 1e-6, 1e-30, decode_float },
    { VK_FORMAT_R16G16B16A16_SFLOAT, 8, 65504, 1.0 / 1024, 1e-7, decode_half },
    { VK_FORMAT_B10G11R11_UFLOAT_PACK32, 4, 64512, 1.0 / 32, 1e-5, decode_b10g11r11 },
    { VK_FORMAT_R8G8B8A8_UNORM, 4, 1, 0, 1.0 / 255, decode_rgba8 },
    { VK_FORMAT_B8G8R8A8_UNORM, 4, 1, 0, 1.0 / 255, decode_bgra8 },
    { VK_FORMAT_R8G8B8A8_SRGB, 4, 1, 0, 1.0 / 255, decode_rgba8_srgb },
    { VK_FORMAT_B8G8R8A8_SRGB, 4, 1, 0, 1.0 / 255, decode_bgra8_srgb },
};
#define TARGETS (sizeof targets / sizeof *targets)

/* A ball under a light that makes some of it brighter than 1, or than any half. */
static struct stp_scene *bright_ball(struct engine *e, float light)
{
    struct stp_scene *scene = stage_ball(e, 900, true, 1, 1);
    const struct stp_light lights[] = { { .at_eye = true, .color = { light, light, light } } };
    assert_int_equal(stp_scene_set_lights(NULL, scene, lights, 1), STP_OK);
    return scene;
}

/* sRGB: a step of what is kept, which is the encoded value. */
static double step_at(const struct target *target, int channel, double value)
{
    bool srgb = target->decode == decode_rgba8_srgb || target->decode == decode_bgra8_srgb;
    if (srgb && channel < 3)
        return linear(encoded(value) + 1.0 / 255) - value;
    return target->relative * value + target->absolute;
}

struct drawn {
    struct stp_plan *plan;
    struct stp_resident *resident;
};

/* Twice: over `below` for what there is, left for copies; then again from there, in place or over
 * it. The texels. */
static void *draw(struct stage *s, const struct drawn *d, const struct target *target,
                  enum stp_composite composite, const float below[4])
{
    struct engine *e = &s->engine;
    struct stp_host_frame_params params = { .color_format = target->format,
                                            .composite = composite };
    struct stp_frame *frame = stage_frame(e, s->context, d->plan, &params);
    struct stp_targets targets_of = stage_targets(s);
    VkClearValue value = { 0 };
    memcpy(value.color.float32, below, sizeof value.color.float32);
    VkCommandBuffer commands = engine_begin(e, 0);
    if (composite == STP_COMPOSITE_REPLACE) { /* nothing of before is kept */
        targets_of.color.before = VK_IMAGE_LAYOUT_UNDEFINED;
        targets_of.color.after = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        assert_int_equal(
            stp_frame_record(&e->env, frame, d->resident, &s->camera, &targets_of, commands),
            STP_OK);
        targets_of.color.before = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
        targets_of.color.after = VK_IMAGE_LAYOUT_GENERAL;
    } else {
        engine_clear(commands, &s->color, &value);
    }
    assert_int_equal(
        stp_frame_record(&e->env, frame, d->resident, &s->camera, &targets_of, commands), STP_OK);
    engine_submit(e, 0);
    void *texels = engine_read(e, &s->color, target->bytes);
    stp_frame_destroy(&frame);
    return texels;
}

static void expect(const struct target *target, enum stp_composite composite, const void *texels,
                   const struct stp_image *picture, const float below[4], size_t *clamped)
{
    static const char *const names[] = { "R", "G", "B", "A" };
    const float *alpha = stage_plane(picture, "A");
    bool over = composite == STP_COMPOSITE_OVER;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
        double rgba[4];
        target->decode((const char *)texels + i * target->bytes, rgba);
        for (int k = 0; k < 4; k++) {
            double own = (double)stage_plane(picture, names[k])[i];
            double beneath = over ? (1 - (double)alpha[i]) * (double)below[k] : 0;
            double right = fmin(fmin(own, target->most) + beneath, target->most);
            *clamped += own > target->most;
            /* Below it was rounded before. */
            double step = step_at(target, k, right) * (over ? 2 : 1);
            if (!isnan(rgba[k]) && !(fabs(rgba[k] - right) <= step))
                fail_msg("format %d, %s: %s of pixel %zu is %g, not %g", target->format,
                         over ? "over" : "in place", names[k], i, rgba[k], right);
        }
    }
}

static void test_formats(void **state)
{
    const struct stp_render_params params = { .method = STP_METHOD_TWO_PASS,
                                              .path = STP_PATH_COMPUTE,
                                              .samples = 4 }; /* alphas between 0 and 1 */
    const float below[4] = { 0.25f, 0.5f, 0.125f, 1 };
    const float lights[] = { 3, 3e5f };
    struct stage s;
    stage_open(&s, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_D32_SFLOAT, NULL);
    for (unsigned l = 0; l < 2; l++) {
        struct stp_scene *scene = bright_ball(&s.engine, lights[l]);
        struct drawn d = { .plan = stage_plan(&s.engine, s.context, scene, &s.camera, &params) };
        d.resident = stage_resident(&s.engine, s.context, scene, d.plan, NULL);
        struct stp_image *picture = stage_offline(&s.engine, scene, &s.camera, &params);
        for (unsigned t = 0; t < TARGETS; t++) {
            size_t clamped = 0;
            engine_image_close(&s.engine, &s.color);
            engine_image_open(&s.engine, targets[t].format, WIDTH, HEIGHT, &s.color);
            for (int over = l == 0 ? 0 : 1; over < 2; over++) {
                enum stp_composite composite = over ? STP_COMPOSITE_OVER : STP_COMPOSITE_REPLACE;
                void *texels = draw(&s, &d, &targets[t], composite, below);
                expect(&targets[t], composite, texels, picture, below, &clamped);
                free(texels);
            }
            assert_int_equal(clamped > 0, targets[t].most < (l == 0 ? 2 : 1e6));
        }
        stp_image_destroy(&picture);
        stp_resident_destroy(&d.resident);
        stp_plan_destroy(&d.plan);
        stp_scene_destroy(&scene);
    }
    stage_close(&s);
}

static void test_refused(void **state)
{
    const struct {
        struct stp_host_frame_params params;
        const char *words;
    } wrong[] = {
        { { .color_format = VK_FORMAT_R8_UNORM }, "color format" },
        { { .color_format = VK_FORMAT_R8G8B8A8_UNORM, .depth_format = VK_FORMAT_R32_SFLOAT },
          "depth format" },
    };
    const struct stp_render_params params = { .method = STP_METHOD_EXACT };
    struct stage s;
    stage_open(&s, VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_D32_SFLOAT, NULL);
    struct stp_plan *plan = stage_plan(&s.engine, s.context, s.scene, &s.camera, &params);
    for (unsigned i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct stp_frame *frame = NULL;
        unsigned lines = s.engine.lines;
        assert_int_equal(stp_frame_create(&s.engine.env, s.context, plan, &wrong[i].params, &frame),
                         STP_ERROR_ARGUMENT);
        assert_null(frame);
        assert_int_equal(s.engine.lines, lines + 1);
        assert_non_null(strstr(s.engine.last, wrong[i].words));
    }
    stp_plan_destroy(&plan);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_formats),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
