#include "group_device.h"

struct device device;

int open_device(void **state)
{
    device_open(&device, 0);
    return 0;
}

int close_device(void **state)
{
    device_close(&device);
    return 0;
}
