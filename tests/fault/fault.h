/* A stand-in for the Vulkan loader that makes calls fail. The tests put its folder first on
 * LD_LIBRARY_PATH: the library and the command, as shipped, then open it by the loader's name, and
 * it hands everything on to the real one. It
 *   - fails the n-th call that may fail, with a result that the specification allows that call;
 *   - keeps a list of what was created and not destroyed, and notes what is destroyed twice, or
 *     while a submission that may use it was never waited for;
 *   - can pretend that device memory is out of the host's sight, as on a GPU with its own memory,
 *     and that there are many devices.
 * A test in process finds the functions below by dlsym; for the command there are variables:
 * FAULT_AT, FAULT_CHOICE, FAULT_STICKY, FAULT_DISCRETE, FAULT_CROWD, and FAULT_REPORT, a file that
 * gets one line "calls N injected NAME RESULT live N misuse TEXT" when the process ends. */
#ifndef TEST_FAULT_H
#define TEST_FAULT_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

struct fault_state {
    unsigned long calls;  /* that may fail, since fault_arm */
    const char *injected; /* name of the call that was made to fail; "" when none was */
    VkResult result;      /* of that call */
    unsigned live;        /* objects: created and not destroyed */
    char misuse[160];     /* the first wrong use; "" when there was none */
};

/* n: the n-th call from now on fails, 0: none does. choice: which of its results, modulo how many
 * it has. sticky: every later call of that name fails too. */
typedef void fault_arm_fn(unsigned long n, unsigned choice, bool sticky);
/* A choice: VK_ERROR_DEVICE_LOST, from calls too that the specification does not allow it. */
#define FAULT_LOST 1000
typedef void fault_discrete_fn(bool discrete);
/* The first device so often; 0: each once. */
typedef void fault_crowd_fn(unsigned devices);
typedef struct fault_state fault_read_fn(void);

#endif
