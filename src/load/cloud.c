#include "load/cloud.h"

#include "base/log.h"
#include "base/memory.h"

void cloud_release(struct cloud *cloud)
{
    mem_free(cloud->position);
    mem_free(cloud->normal);
    mem_free(cloud->radius);
    mem_free(cloud->color);
    mem_free(cloud->opacity);
    mem_free(cloud->phong);
    mem_free(cloud->objects);
    mem_free(cloud->object);
    for (unsigned i = 0; i < cloud->field_count; i++)
        mem_free(cloud->fields[i].value);
    mem_free(cloud->fields);
    *cloud = (struct cloud){ 0 };
}

enum stp_result cloud_give_radius(const struct stp_env *env, float radius, struct cloud *cloud)
{
    if (cloud->radius || cloud->phong || cloud->count == 0 || !(radius > 0))
        return STP_OK;
    cloud->radius = mem_alloc(cloud->count, sizeof *cloud->radius);
    if (!cloud->radius)
        return log_no_memory(env, cloud->count * sizeof *cloud->radius, "radii");
    for (size_t i = 0; i < cloud->count; i++)
        cloud->radius[i] = radius;
    return STP_OK;
}
