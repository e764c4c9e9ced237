/* Every Vulkan call of a context's making, and of a list of devices, made to fail in turn. */
#include "subject.h"

#include "base/memory.h"

#define RESULTS 4 /* most results that one call may fail with */

/* What a caller gets for the VkResult before there is a device. */
static enum stp_result wanted(const struct fault_state *seen)
{
    switch (seen->result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return STP_ERROR_MEMORY;
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return STP_ERROR_DEVICE_MEMORY;
    default:
        return strcmp(seen->injected, "vkCreateInstance") == 0 ? STP_ERROR_NO_DEVICE
                                                               : STP_ERROR_DEVICE;
    }
}

static void check(const struct fault_controls *fault, enum stp_result result,
                  const struct device *device)
{
    struct fault_state seen = fault->read();
    if (seen.injected[0] && (result != wanted(&seen) || device->lines != 1))
        fail_msg("%s gives VkResult %d: %s, %u lines, the last: %s", seen.injected, seen.result,
                 stp_result_text(result), device->lines, device->last);
    assert_true(seen.injected[0] || result == STP_OK);
}

/* False: no call was made to fail, and there was a context. */
static bool fail_context(const struct fault_controls *fault, unsigned long n, unsigned choice,
                         bool validate)
{
    struct device device;
    struct stp_context_params params = { .validate = validate };
    device_silent(&device);
    fault->arm(n, choice, false);
    enum stp_result result = stp_context_create(&device.env, &params, &device.context);
    bool injected = fault->read().injected[0] != 0;
    check(fault, result, &device);
    assert_true(injected == !device.context);
    fault->arm(0, 0, false);
    stp_context_destroy(&device.context);
    no_misuse(fault, "context", 0);
    return injected;
}

static void test_contexts(void **state)
{
    struct fault_controls fault = find_faults();
    for (int validate = 0; validate < 2; validate++)
        for (unsigned choice = 0; choice < (validate ? 1 : RESULTS); choice++) {
            unsigned long n = 1;
            while (fail_context(&fault, n, choice, validate))
                n++;
            assert_true(n >= 10); /* it did go through the calls */
        }
}

static void test_context_memory(void **state)
{
    struct fault_controls fault = find_faults();
    struct stp_context_params params = { 0 };
    struct device device;
    device_silent(&device);
    for (unsigned long n = 1; !device.context; n++) {
        device.lines = 0;
        mem_fail_at(n);
        enum stp_result result = stp_context_create(&device.env, &params, &device.context);
        mem_fail_at(0);
        assert_int_equal(result, device.context ? STP_OK : STP_ERROR_MEMORY);
        assert_int_equal(device.lines, device.context ? 0 : 1);
    }
    stp_context_destroy(&device.context);
    no_misuse(&fault, "context", 0);
}

/* Whatever waiting says, what there is goes away. */
static void test_destroying(void **state)
{
    struct fault_controls fault = find_faults();
    struct stp_context_params params = { 0 };
    struct stp_context *context = NULL;
    assert_int_equal(stp_context_create(NULL, &params, &context), STP_OK);
    fault.arm(1, 2, true);
    stp_context_destroy(&context);
    assert_string_equal(fault.read().injected, "vkDeviceWaitIdle");
    fault.arm(0, 0, false);
    no_misuse(&fault, "context", 0);
}

static void test_devices(void **state)
{
    struct fault_controls fault = find_faults();
    bool injected = true;
    for (unsigned long n = 1; injected; n++) {
        struct device device;
        struct stp_device_info info;
        unsigned count = 77;
        device_silent(&device);
        fault.arm(n, (unsigned)n, false);
        enum stp_result result = stp_devices(&device.env, &info, 1, &count);
        injected = fault.read().injected[0] != 0;
        check(&fault, result, &device);
        assert_int_equal(count == 77, injected);
        fault.arm(0, 0, false);
        no_misuse(&fault, "devices", 0);
    }
}

/* More devices than anybody has: all are listed, as far as there is room, and counted. */
static void test_crowd(void **state)
{
    enum { CROWD = 40 };
    struct fault_controls fault = find_faults();
    struct stp_device_info info[CROWD + 1];
    struct stp_context *context = NULL;
    unsigned count = 0;
    fault.crowd(CROWD);
    assert_int_equal(stp_devices(NULL, NULL, 0, &count), STP_OK);
    assert_int_equal(count, CROWD);
    for (unsigned room = CROWD - 1; room <= CROWD + 1; room++) {
        memset(info, 0xaa, sizeof info);
        count = 0;
        assert_int_equal(stp_devices(NULL, info, room, &count), STP_OK);
        assert_int_equal(count, CROWD);
        for (unsigned i = 1; i < CROWD && i < room; i++)
            assert_memory_equal(&info[i], &info[0], sizeof info[0]);
        const unsigned char *past = (const unsigned char *)&info[room < CROWD ? room : CROWD];
        assert_int_equal(*past, 0xaa);
    }
    assert_int_equal(stp_context_create(NULL, NULL, &context), STP_OK);
    stp_context_destroy(&context);
    fault.crowd(0);
    no_misuse(&fault, "crowd", 0);
}

/* Every allocation of a list fails in turn. */
static void test_devices_memory(void **state)
{
    struct fault_controls fault = find_faults();
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        struct device device;
        struct stp_device_info info;
        unsigned count = 77;
        device_silent(&device);
        mem_fail_at(n);
        result = stp_devices(&device.env, &info, 1, &count);
        mem_fail_at(0);
        assert_true(result == STP_OK || (result == STP_ERROR_MEMORY && count == 77));
        assert_int_equal(device.lines, result == STP_OK ? 0 : 1);
        assert_true(n > 1 || result != STP_OK); /* there is one to fail */
        no_misuse(&fault, "devices", 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_contexts),       cmocka_unit_test(test_context_memory),
        cmocka_unit_test(test_destroying),     cmocka_unit_test(test_devices),
        cmocka_unit_test(test_devices_memory), cmocka_unit_test(test_crowd),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
