#include "load/cloud.h"

#include "base/memory.h"

void cloud_release(struct cloud *cloud)
{
    mem_free(cloud->position);
    mem_free(cloud->normal);
    mem_free(cloud->radius);
    mem_free(cloud->color);
    mem_free(cloud->opacity);
    mem_free(cloud->phong);
    for (unsigned i = 0; i < cloud->field_count; i++)
        mem_free(cloud->fields[i].value);
    mem_free(cloud->fields);
    *cloud = (struct cloud){ 0 };
}
