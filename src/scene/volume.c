/* Volumes into scenes. */
#include "scene/volume.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/scene.h"

void kernels_release(struct kernels *kernels)
{
    mem_free(kernels->voxel);
    mem_free(kernels->color);
    mem_free(kernels->tau);
    mem_free(kernels->normal);
    mem_free(kernels->place);
    mem_free(kernels->axes);
    mem_free(kernels->source_first);
    mem_free(kernels->source);
    mem_free(kernels->source_color);
    *kernels = (struct kernels){ 0 };
}

void volume_release(struct volume **volume)
{
    if (!*volume)
        return;
    grid_release(&(*volume)->grid);
    range_release(&(*volume)->range);
    kernels_release(&(*volume)->kernels);
    mem_free(*volume);
    *volume = NULL;
}

enum stp_result volume_set_transfer(const struct stp_env *env, struct volume *volume,
                                    const struct stp_volume_params *params)
{
    const char *name = params ? params->transfer_function : NULL;
    struct transfer_function function = { .name = "auto" };
    bool automatic = !name || strcmp(name, "auto") == 0;
    if (!automatic && !transfer_preset(name, &function)) {
        enum stp_result result = transfer_load(env, name, &function);
        if (result != STP_OK)
            return result;
    }
    volume->transfer = function;
    volume->automatic = automatic;
    volume->unshaded = params && params->unshaded;
    return STP_OK;
}

/* The one object, which holds the material, and the facts that are known before prepare. */
static enum stp_result attach(const struct stp_env *env, struct stp_scene *scene,
                              struct volume *volume, const struct stp_material *material)
{
    struct cloud nothing = { .up = volume->grid.up };
    const struct stp_object_params object = { .material = material };
    memcpy(nothing.format, volume->grid.format, sizeof nothing.format);
    enum stp_result result = scene_add_cloud(env, scene, &nothing, &object);
    if (result != STP_OK)
        return result;
    struct stp_volume_facts *facts = &scene->facts.volume;
    memcpy(facts->dims, volume->grid.dims, sizeof facts->dims);
    memcpy(facts->spacing, volume->grid.spacing, sizeof facts->spacing);
    facts->low = volume->grid.low;
    facts->high = volume->grid.high;
    scene->facts.points = grid_count(&volume->grid);
    scene->volume = volume;
    return STP_OK;
}

enum stp_result scene_add_volume(const struct stp_env *env, struct stp_scene *scene,
                                 struct grid *grid, const struct stp_volume_params *params,
                                 const struct stp_material *material)
{
    if (scene->object_count > 0)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "a scene holds one volume, or points: this one holds something already");
    struct volume *volume = mem_zalloc(1, sizeof *volume);
    if (!volume)
        return log_no_memory(env, sizeof *volume, "a volume");
    enum stp_result result = volume_set_transfer(env, volume, params);
    volume->grid = *grid;
    if (result == STP_OK)
        result = attach(env, scene, volume, material);
    if (result == STP_OK)
        *grid = (struct grid){ 0 };
    else
        mem_free(volume);
    return result;
}

enum stp_result stp_scene_set_volume(const struct stp_env *env, struct stp_scene *scene,
                                     const struct stp_volume *volume,
                                     const struct stp_volume_params *params)
{
    struct voxels voxels = { .has_origin = true };
    for (int i = 0; i < 3; i++) {
        voxels.dims[i] = volume->dims[i];
        voxels.spacing[i] = volume->spacing[i];
        voxels.origin[i] = volume->origin[i];
    }
    if (!volume->value || voxels_check(env, "the volume", &voxels) != STP_OK)
        return volume->value ? STP_ERROR_ARGUMENT
                             : log_error(env, STP_ERROR_ARGUMENT, "a volume needs its values");
    struct grid grid = { .up = STP_UP_Y };
    memcpy(grid.dims, volume->dims, sizeof grid.dims);
    memcpy(grid.spacing, volume->spacing, sizeof grid.spacing);
    memcpy(grid.origin, volume->origin, sizeof grid.origin);
    size_t count = grid_count(&grid);
    grid.value = mem_alloc(count, sizeof *grid.value);
    if (!grid.value)
        return log_no_memory(env, count * sizeof *grid.value, "voxels");
    memcpy(grid.value, volume->value, count * sizeof *grid.value);
    grid_measure(&grid);
    enum stp_result result = scene_add_volume(env, scene, &grid, params, NULL);
    grid_release(&grid);
    return result;
}
