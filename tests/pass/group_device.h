/* One validated device for all tests of a program. */
#ifndef TEST_PASS_GROUP_DEVICE_H
#define TEST_PASS_GROUP_DEVICE_H

#include "device.h"

extern struct device device;

/* What cmocka_run_group_tests calls before and after a program's tests. */
int open_device(void **state);
int close_device(void **state);

#endif
