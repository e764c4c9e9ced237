/* Transfer functions: evaluation and presets. */
#include <math.h>
#include <string.h>

#include "scene/volume.h"

struct transfer_point transfer_at(const struct transfer_function *function, double value)
{
    const struct transfer_point *p = function->point;
    unsigned low = 0, high = function->count;
    if (isnan(value) || function->count == 0)
        return (struct transfer_point){ .value = value };
    while (low < high) { /* the first point above the value */
        unsigned middle = (low + high) / 2;
        if (p[middle].value > value)
            high = middle;
        else
            low = middle + 1;
    }
    if (low == 0 || low == function->count)
        return p[low == 0 ? 0 : low - 1];
    const struct transfer_point *a = &p[low - 1], *b = &p[low];
    double t = (value - a->value) / (b->value - a->value);
    struct transfer_point at = { .value = value };
    for (int c = 0; c < 3; c++)
        at.color[c] = (float)((double)a->color[c] * (1 - t) + (double)b->color[c] * t);
    at.opacity = (float)((double)a->opacity * (1 - t) + (double)b->opacity * t);
    return at;
}

/* Of the range of the values; colours linear. */
static const struct transfer_function presets[] = {
    { .name = "grey",
      .of_range = true,
      .count = 3,
      .point = { { 0, { 0.8f, 0.8f, 0.8f }, 0 },
                 { 0.1, { 0.8f, 0.8f, 0.8f }, 0 },
                 { 1, { 0.9f, 0.9f, 0.9f }, 0.5f } } },
    { .name = "bone",
      .of_range = true,
      .count = 4,
      .point = { { 0, { 0.7f, 0.5f, 0.35f }, 0 },
                 { 0.4, { 0.7f, 0.5f, 0.35f }, 0 },
                 { 0.5, { 0.85f, 0.75f, 0.55f }, 0.4f },
                 { 1, { 0.95f, 0.9f, 0.8f }, 0.9f } } },
    { .name = "flesh",
      .of_range = true,
      .count = 6,
      .point = { { 0, { 0.8f, 0.35f, 0.2f }, 0 },
                 { 0.22, { 0.8f, 0.35f, 0.2f }, 0 },
                 { 0.3, { 0.85f, 0.4f, 0.25f }, 0.02f },
                 { 0.4, { 0.85f, 0.45f, 0.3f }, 0.03f },
                 { 0.5, { 0.9f, 0.8f, 0.6f }, 0.5f },
                 { 1, { 0.95f, 0.9f, 0.8f }, 0.9f } } },
    { .name = "hot",
      .of_range = true,
      .count = 5,
      .point = { { 0, { 0, 0, 0 }, 0 },
                 { 0.1, { 0.2f, 0, 0 }, 0 },
                 { 0.4, { 0.8f, 0.05f, 0 }, 0.05f },
                 { 0.7, { 1, 0.5f, 0.02f }, 0.2f },
                 { 1, { 1, 1, 0.7f }, 0.6f } } },
};

bool transfer_preset(const char *name, struct transfer_function *function)
{
    for (size_t i = 0; i < sizeof presets / sizeof *presets; i++)
        if (strcmp(presets[i].name, name) == 0) {
            *function = presets[i];
            return true;
        }
    return false;
}
