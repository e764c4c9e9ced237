/* Ellipsoids of range images, as the view weights and colours them. */
#include <string.h>

#include "base/thread.h"
#include "prepare/range.h"
#include "record/record.h"
#include "scene/scene.h"

struct packing {
    const struct stp_scene *scene;
    struct range_view view;
    float (*out)[STP_ELLIPSOID][4];
};

/* Centre relative to the origin and tau; colour; three axes, one after the other. */
static void pack(void *context, size_t begin, size_t end, unsigned)
{
    const struct packing *p = context;
    const struct volume *volume = p->scene->volume;
    for (size_t i = begin; i < end; i++) {
        float(*out)[4] = p->out[i];
        double color[3];
        range_color(volume, &p->view, i, color);
        for (int a = 0; a < 3; a++) {
            out[0][a] = (float)(volume->kernels.place[i][a] - p->scene->splats.origin[a]);
            out[1][a] = (float)color[a];
            out[4][a + 1] = 0;
        }
        out[0][3] = (float)range_tau(volume, &p->view, i);
        out[1][3] = 0;
        memcpy(out[2], volume->kernels.axes[i], sizeof volume->kernels.axes[i]);
    }
}

enum stp_result upload_ellipsoids(const struct stp_env *env, struct record_frame *frame,
                                  const struct stp_scene *scene, struct gpu_buffer *buffer)
{
    size_t count = scene->volume->kernels.count;
    struct packing packing = { scene, range_view_of(&frame->plan->camera), NULL };
    packing.out = gpu_fill_begin(env, buffer, count, sizeof *packing.out, "ellipsoids");
    if (!packing.out)
        return STP_ERROR_MEMORY;
    parallel_for(env, count, 16384, pack, &packing);
    return gpu_fill_end(env, frame->context, buffer, packing.out, count * sizeof *packing.out);
}
