/* Where a picture is wrong: the error in false colours, reduced. */
#include "report/report.h"

#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

/* sRGB, from no error to large: dark violet, blue, teal, green, yellow. */
static const unsigned char ramp[][3] = { { 26, 8, 48 },    { 59, 44, 128 },  { 41, 98, 152 },
                                         { 27, 146, 140 }, { 74, 190, 103 }, { 170, 220, 50 },
                                         { 253, 231, 37 } };
#define RAMP_STEPS (sizeof ramp / sizeof *ramp - 1)
#define BAR_HEIGHT 10
#define BAR_GAP    4

static float to_linear(double srgb)
{
    return (float)(srgb <= 0.04045 ? srgb / 12.92 : pow((srgb + 0.055) / 1.055, 2.4));
}

void heat_color(double error, float rgb[3])
{
    double at = log(error / HEAT_LOW) / log(HEAT_HIGH / HEAT_LOW) * RAMP_STEPS;
    if (!(at > 0))
        at = 0;
    unsigned step = at < RAMP_STEPS ? (unsigned)at : (unsigned)RAMP_STEPS - 1;
    double share = at < RAMP_STEPS ? at - step : 1;
    for (int k = 0; k < 3; k++)
        rgb[k] = to_linear((ramp[step][k] + share * (ramp[step + 1][k] - ramp[step][k])) / 255);
}

struct measuring {
    const struct heat *heat;
    uint32_t width, height;
    const float *a[4], *b[4];
};

static double pixel_error(const struct measuring *m, size_t i)
{
    double worst = 0;
    for (int k = 0; k < 3; k++)
        worst = fmax(worst, fabs((double)m->a[k][i] - m->b[k][i]));
    return worst;
}

/* The mean over the source pixels of one cell that either picture covers. */
static float cell(const struct measuring *m, uint32_t x, uint32_t y)
{
    uint64_t w = m->heat->width, h = m->heat->height;
    uint32_t x1 = (uint32_t)((uint64_t)(x + 1) * m->width / w);
    uint32_t y1 = (uint32_t)((uint64_t)(y + 1) * m->height / h);
    double sum = 0;
    unsigned count = 0;
    for (uint32_t j = (uint32_t)((uint64_t)y * m->height / h); j < y1; j++) {
        for (uint32_t i = (uint32_t)((uint64_t)x * m->width / w); i < x1; i++) {
            size_t at = (size_t)j * m->width + i;
            if (m->a[3][at] > 0 || m->b[3][at] > 0) {
                sum += pixel_error(m, at);
                count++;
            }
        }
    }
    return count ? (float)(sum / count) : -1;
}

static void measure_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct measuring *m = context;
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < m->heat->width; x++)
            m->heat->error[y * m->heat->width + x] = cell(m, x, (uint32_t)y);
}

enum stp_result heat_measure(const struct stp_env *env, const struct stp_image *image,
                             const struct stp_image *reference, struct heat *heat)
{
    static const char *const names[] = { "R", "G", "B", "A" };
    struct measuring m = { heat, image->width, image->height, { NULL }, { NULL } };
    for (int k = 0; k < 4; k++) {
        const struct stp_channel *a = stp_image_find(image, names[k]);
        const struct stp_channel *b = stp_image_find(reference, names[k]);
        if (!a || !b || image->width != reference->width || image->height != reference->height)
            return log_error(env, STP_ERROR_ARGUMENT, "the pictures of an error differ in shape");
        m.a[k] = a->data.f;
        m.b[k] = b->data.f;
    }
    uint32_t width = m.width < HEAT_WIDTH ? m.width : HEAT_WIDTH;
    uint32_t height = (uint32_t)((uint64_t)m.height * width / m.width);
    struct heat made = { width, height ? height : 1, NULL };
    made.error = mem_alloc((size_t)made.width * made.height, sizeof *made.error);
    if (!made.error)
        return log_no_memory(env, (size_t)made.width * made.height * 4, "a picture of the error");
    *heat = made;
    parallel_for(env, heat->height, 16, measure_rows, &m);
    return STP_OK;
}

void heat_release(struct heat *heat)
{
    mem_free(heat->error);
    *heat = (struct heat){ 0 };
}

static void put(float *const plane[4], size_t at, const float rgb[3])
{
    for (int k = 0; k < 3; k++)
        plane[k][at] = rgb[k];
    plane[3][at] = 1;
}

static void paint(const struct heat *heat, float *const plane[4])
{
    const float paper[3] = { to_linear(0.93), to_linear(0.93), to_linear(0.94) };
    size_t pixels = (size_t)heat->width * heat->height, w = heat->width;
    float rgb[3];
    for (size_t i = 0; i < pixels; i++) {
        heat_color(heat->error[i], rgb);
        put(plane, i, heat->error[i] < 0 ? paper : rgb);
    }
    for (size_t i = 0; i < (BAR_GAP + BAR_HEIGHT) * w; i++) {
        double share = ((double)(i % w) + 0.5) / (double)w;
        heat_color(HEAT_LOW * pow(HEAT_HIGH / HEAT_LOW, share), rgb);
        put(plane, pixels + i, i < BAR_GAP * w ? paper : rgb);
    }
}

enum stp_result heat_picture(const struct stp_env *env, const struct heat *heat,
                             struct stp_image **picture)
{
    static const char *const names[] = { "R", "G", "B", "A" };
    struct stp_image *made = NULL;
    float *plane[4];
    enum stp_result result =
        stp_image_create(env, heat->width, heat->height + BAR_GAP + BAR_HEIGHT, &made);
    for (int k = 0; result == STP_OK && k < 4; k++) {
        struct stp_channel *channel;
        result = stp_image_add(env, made, names[k], STP_CHANNEL_FLOAT, &channel);
        if (result == STP_OK)
            plane[k] = channel->data.f;
    }
    if (result != STP_OK) {
        stp_image_destroy(&made);
        return result;
    }
    paint(heat, plane);
    *picture = made;
    return STP_OK;
}
