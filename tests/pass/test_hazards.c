/* What passes wait for, by hand and by a model of Vulkan's rules that knows every pass before. No
 * device. */
#include "record/hazards.h"

#include "fixture.h"
#include <string.h>

#define COMPUTE  VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT
#define DRAWING  (VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT)
#define ATTACHED VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT

static struct stp_plan plan; /* resources: a buffer, an image of 8 layers, another buffer */

static int open_plan(void **state)
{
    plan.resource_count = 3;
    plan.resource[1].format = PLAN_RGBA32F;
    plan.resource[1].layers = 8;
    return 0;
}

static struct plan_pass pass_of(enum plan_kind kind, uint8_t resource, uint8_t access)
{
    struct plan_pass pass = { .kind = kind, .access_count = 1 };
    pass.access[0] = (struct plan_access){ .resource = resource, .kind = access };
    return pass;
}

static struct plan_pass draw_layer(uint32_t layer)
{
    struct plan_pass pass = pass_of(PLAN_DRAW, 1, PLAN_READ | PLAN_WRITE | PLAN_ATTACHMENT);
    pass.layer = layer;
    pass.layer_count = 1;
    return pass;
}

static VkMemoryBarrier2 add(struct hazards *hazards, struct plan_pass pass)
{
    VkMemoryBarrier2 memory = { 0 };
    hazards_add(hazards, &plan, &pass, &memory);
    return memory;
}

static void waits_for(struct hazards *hazards, struct plan_pass pass, VkPipelineStageFlags2 from)
{
    assert_int_equal(add(hazards, pass).srcStageMask, from);
}

/* A reader waits once for each of its stages, a writer for all of them. */
static void test_readers(void **state)
{
    struct hazards hazards = { 0 };
    waits_for(&hazards, pass_of(PLAN_DISPATCH, 0, PLAN_WRITE), 0);
    waits_for(&hazards, pass_of(PLAN_DISPATCH, 0, PLAN_READ), COMPUTE);
    waits_for(&hazards, pass_of(PLAN_DISPATCH, 0, PLAN_READ), 0);
    waits_for(&hazards, pass_of(PLAN_DRAW, 0, PLAN_READ), COMPUTE);
    waits_for(&hazards, pass_of(PLAN_DISPATCH, 0, PLAN_READ), 0);
    waits_for(&hazards, pass_of(PLAN_DRAW, 0, PLAN_READ), 0);
    waits_for(&hazards, pass_of(PLAN_DISPATCH, 0, PLAN_READ | PLAN_WRITE), COMPUTE | DRAWING);
    waits_for(&hazards, pass_of(PLAN_DRAW, 0, PLAN_READ), COMPUTE);
}

/* Draws to layers of their own do not wait for each other; one to a layer again does, and whoever
 * reads waits for all. */
static void test_layers(void **state)
{
    struct hazards hazards = { 0 };
    for (uint32_t i = 0; i < 4; i++)
        waits_for(&hazards, draw_layer(i), 0);
    waits_for(&hazards, draw_layer(2), ATTACHED);
    waits_for(&hazards, draw_layer(5), 0);
    waits_for(&hazards, pass_of(PLAN_DISPATCH, 1, PLAN_READ), ATTACHED);
    waits_for(&hazards, draw_layer(7), ATTACHED | COMPUTE);
}

#define STEPS 24

struct step {
    struct plan_pass pass;
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
    VkPipelineStageFlags2 after;   /* stages that start when the step has ended */
    bool shown;                    /* what it wrote is available */
    VkPipelineStageFlags2 visible; /* to these stages */
};

static bool attaches(const struct step *s)
{
    return (s->pass.access[0].kind & PLAN_ATTACHMENT) != 0;
}

static bool conflict(const struct step *a, const struct step *b)
{
    uint8_t kinds = a->pass.access[0].kind | b->pass.access[0].kind;
    bool apart = attaches(a) && attaches(b) && a->pass.layer != b->pass.layer;
    return a->pass.access[0].resource == b->pass.access[0].resource && (kinds & PLAN_WRITE) &&
           !apart;
}

/* What a barrier does for a step before it. */
static void wait_model(struct step *s, const VkMemoryBarrier2 *b)
{
    bool ended = !(s->stages & ~b->srcStageMask);
    if (ended && (b->srcAccessMask & s->access))
        s->shown = true;
    if (ended || (s->after & b->srcStageMask)) {
        s->after |= b->dstStageMask;
        s->visible |= s->shown ? b->dstStageMask : 0;
    }
}

static struct step random_step(uint32_t *seed)
{
    struct step s = { 0 };
    uint8_t resource = (uint8_t)(3 * uniform(seed)), kind = (uint8_t)(1 + 3 * uniform(seed));
    bool draws = uniform(seed) < 0.5;
    s.stages = draws ? DRAWING : COMPUTE;
    s.access = (kind & PLAN_WRITE) ? VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT : 0;
    s.pass = pass_of(draws ? PLAN_DRAW : PLAN_DISPATCH, resource, kind);
    if (resource == 1 && draws) {
        s.pass = draw_layer((uint32_t)(8 * uniform(seed)));
        s.stages = ATTACHED;
        s.access = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    }
    return s;
}

static void expect_waited(const struct step *before, const struct step *now)
{
    if (!conflict(before, now))
        return;
    assert_false(now->stages & ~before->after);
    if (before->access && (now->pass.access[0].kind & PLAN_READ))
        assert_false(now->stages & ~before->visible);
}

/* Whatever the order of passes, each has waited for all that it conflicts with. */
static void test_any_order(void **state)
{
    uint32_t seed = 5;
    size_t barriers = 0;
    for (int run = 0; run < 5000; run++) {
        struct step step[STEPS];
        struct hazards hazards = { 0 };
        for (int i = 0; i < STEPS; i++) {
            step[i] = random_step(&seed);
            VkMemoryBarrier2 b = add(&hazards, step[i].pass);
            barriers += b.srcStageMask != 0;
            for (int k = 0; k < i && b.srcStageMask; k++)
                wait_model(&step[k], &b);
            for (int k = 0; k < i; k++)
                expect_waited(&step[k], &step[i]);
        }
    }
    assert_in_range(barriers, 1, 5000 * (STEPS - 1)); /* the first never waits */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_readers),
        cmocka_unit_test(test_layers),
        cmocka_unit_test(test_any_order),
    };
    return cmocka_run_group_tests(tests, open_plan, NULL);
}
