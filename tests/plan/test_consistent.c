/* Whatever is asked for, a plan hangs together: accesses name resources that exist, nothing is read
 * before it is written, nothing is made that no pass uses. */
#include "plans.h"

/* Passes may append to these before anything has written them: counters say what is there. */
static bool appended(const struct stp_plan *plan, enum plan_slot slot)
{
    return slot == PLAN_LARGE || slot == PLAN_SLOT_IDS || slot == PLAN_TRAITS || slot == PLAN_RIM ||
           (slot == PLAN_KEYS && plan->method == STP_METHOD_EXACT);
}

static void check_access(const struct stp_plan *plan, const struct plan_pass *pass,
                         const struct plan_access *access, bool *written)
{
    assert_true(access->resource < plan->resource_count);
    const struct plan_resource *r = &plan->resource[access->resource];
    bool reads = access->kind & PLAN_READ, writes = access->kind & PLAN_WRITE;
    bool attachment = access->kind & PLAN_ATTACHMENT;
    assert_true(reads || writes);
    if (attachment)
        assert_true(writes && pass->kind == PLAN_DRAW && r->format != PLAN_BUFFER);
    if (r->lifetime == PLAN_SCENE && writes)
        fail_msg("%s writes %s, which is the scene's", pass->name, r->name);
    bool first = r->lifetime != PLAN_SCENE && !written[access->resource];
    if (first && reads && !attachment && !(writes && appended(plan, r->slot)))
        fail_msg("%s reads %s, which nothing has written", pass->name, r->name);
    written[access->resource] |= writes;
}

static void check_draw(const struct stp_plan *plan, const struct plan_pass *pass)
{
    unsigned attachments = 0;
    assert_true(pass->vertex != PLAN_SHADER_NONE);
    uint8_t order = plan_find(plan, PLAN_ORDER);
    assert_true(pass->first_splat + pass->splat_count <=
                (order == PLAN_NONE ? plan->facts.splats : plan->resource[order].bytes / 4));
    for (unsigned i = 0; i < pass->access_count; i++) {
        const struct plan_resource *r = &plan->resource[pass->access[i].resource];
        if (!(pass->access[i].kind & PLAN_ATTACHMENT))
            continue;
        attachments++;
        /* An image of one layer is every pass's, which clears it. */
        assert_true(pass->layer + pass->layer_count <= r->layers ||
                    (r->layers == 1 && pass->layer_count == 1));
        assert_true(r->width >= plan->tile_width && r->height >= plan->tile_height);
    }
    assert_true(attachments > 0);
}

static void check_pass(const struct stp_plan *plan, const struct plan_pass *pass, bool *written)
{
    bool seen[PLAN_MAX_RESOURCES] = { 0 };
    assert_true(pass->name[0] && pass->access_count > 0);
    for (unsigned i = 0; i < pass->access_count; i++) {
        assert_false(seen[pass->access[i].resource]); /* one access a resource, kinds or-ed */
        seen[pass->access[i].resource] = true;
        check_access(plan, pass, &pass->access[i], written);
    }
    if (pass->kind == PLAN_FILL) { /* with words: of an image they are its first components */
        enum plan_format format = plan->resource[pass->target].format;
        bool buffer = format == PLAN_BUFFER || format == PLAN_TEXELS_RG32UI;
        assert_true(seen[pass->target] && (buffer || format == PLAN_RGBA32UI));
    }
    if (pass->kind == PLAN_ARGUMENTS)
        assert_int_equal(plan->resource[pass->access[0].resource].slot, PLAN_WORK);
    if (pass->kind == PLAN_DISPATCH_INDIRECT) {
        assert_true(pass->offset % 4 == 0 && pass->offset / 4 + 3 <= STP_WORK_FLAGS);
        assert_true(seen[plan_find(plan, PLAN_WORK)]);
    }
    if (pass->kind == PLAN_DRAW)
        check_draw(plan, pass);
    bool runs = pass->kind != PLAN_FILL && pass->kind != PLAN_ARGUMENTS;
    assert_true(runs == (pass->shader != PLAN_SHADER_NONE));
}

static void check_resources(const struct stp_plan *plan)
{
    bool slot[PLAN_SLOTS] = { 0 };
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        const struct plan_resource *r = &plan->resource[i];
        bool used = false;
        assert_true(r->name[0] && r->bytes > 0);
        assert_false(slot[r->slot]);
        slot[r->slot] = true;
        bool slots = r->slot == PLAN_KEYS || r->slot == PLAN_SLOT_IDS || r->slot == PLAN_TRAITS;
        bool words = r->format == PLAN_TEXELS_RG32UI || r->format == PLAN_TEXELS_R32UI;
        bool records = r->slot == PLAN_PROJECTED && r->format == PLAN_TEXELS_RGBA32UI;
        assert_true(records || words ? records || slots
                                     : (r->format == PLAN_BUFFER) == (r->slot < PLAN_BUFFER_SLOTS));
        for (uint32_t p = 0; p < plan->pass_count; p++)
            for (unsigned a = 0; a < plan->pass[p].access_count; a++)
                used |= plan->pass[p].access[a].resource == i;
        if (!used)
            fail_msg("no pass uses %s", r->name);
    }
    assert_true(slot[PLAN_OUT_COLOR] && slot[PLAN_OUT_NORMAL] && slot[PLAN_OUT_DEPTH]);
}

/* Every splat is drawn once in every geometry pass; every member of the groups that each cover the
 * surface, and for the nearest layer every splat once more. */
static void check_layers(const struct stp_plan *plan)
{
    size_t drawn = 0;
    if (plan->method != STP_METHOD_DEFERRED || plan->path != STP_PATH_RASTER)
        return;
    for (uint32_t i = 0; i < plan->pass_count; i++)
        drawn += plan->pass[i].kind == PLAN_DRAW ? plan->pass[i].splat_count : 0;
    size_t expected = plan_covers(plan) ? plan->facts.cover.members : plan->facts.splats;
    if (plan->transparency == STP_TRANSPARENCY_NEAREST)
        expected += plan->facts.splats;
    assert_int_equal(drawn, expected);
}

static void check_plan(const struct stp_plan *plan)
{
    bool written[PLAN_MAX_RESOURCES] = { 0 };
    assert_true(plan->pass_count > 0 && plan->pass_count <= PLAN_MAX_PASSES);
    assert_true(plan->tile_count > 0 && plan->why[0]);
    check_resources(plan);
    for (uint32_t i = 0; i < plan->pass_count; i++)
        check_pass(plan, &plan->pass[i], written);
    for (uint32_t i = 0; i < plan->resource_count; i++)
        assert_true(plan->resource[i].lifetime == PLAN_SCENE || written[i]);
    check_layers(plan);
    struct stp_plan_summary summary;
    stp_plan_summarize(plan, &summary);
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < plan->resource_count; i++)
        bytes += plan->resource[i].bytes;
    assert_int_equal(bytes, summary.scene_bytes + summary.transient_bytes + summary.output_bytes);
}

static void random_inputs(struct inputs *in, uint32_t *seed)
{
#define DICE(n) ((unsigned)(uniform(seed) * (n)))
    static const float background[] = { 1, 1, 1, 1 };
    if (DICE(2))
        color_inputs(in);
    in->scene->facts.objects = 1 + DICE(2);
    in->scene->facts.eye_dome = DICE(4) == 0;
    in->scene->facts.no_normal = DICE(2);
    in->scene->facts.grouping.groups = 4 + DICE(61);
    in->scene->facts.grouping.overlap = DICE(2) ? 1 : 0.5;
    in->scene->objects[0].epsilon = pow(10, -DICE(8));
    bool faded = DICE(3) == 0;
    if (faded) {
        fade_inputs(in, DICE(2));
        cover_inputs(in);
    }
    in->camera = DICE(3) ? plain_camera(1 + DICE(400), 1 + DICE(300), 100)
                         : flat_camera(1 + DICE(400), 1 + DICE(300), 100);
    in->params = (struct stp_render_params){ .method = (enum stp_method)(DICE(4)),
                                             .path = (enum stp_path)(DICE(3)),
                                             .payload = (enum stp_payload)(DICE(3)),
                                             .voronoi = (enum stp_voronoi)(DICE(4)),
                                             .aovs = DICE(128),
                                             .background = DICE(2) ? background : NULL,
                                             .mask_features = DICE(2) ? DICE(32) : 0,
                                             .memory_limit = DICE(2) ? 1u << (17 + DICE(6)) : 0 };
    if (DICE(5) == 0)
        in->params.method = STP_METHOD_PYRAMID;
    if (faded && DICE(4)) {
        in->params.method = STP_METHOD_AUTO;
        in->params.transparency = (enum stp_transparency)(DICE(5));
        in->params.path = DICE(2) ? STP_PATH_RASTER : STP_PATH_AUTO;
        in->params.aovs &= DICE(2) ? ~(unsigned)STP_AOV_LAYERS : ~0u;
    }
    in->limits.processor = 1 + DICE(2);
#undef DICE
}

static void test_random_plans(void **state)
{
    unsigned made = 0;
    uint32_t seed = 12345;
    for (int i = 0; i < 3000; i++) {
        struct plan_log log = { 0 };
        struct stp_env env = { .log = plan_keep_line, .user = &log };
        struct inputs in = plain_inputs();
        struct stp_plan *plan = NULL, *again = NULL;
        random_inputs(&in, &seed);
        enum stp_result result =
            stp_plan_create(&env, in.scene, &in.camera, &in.params, &in.limits, &plan);
        if (result == STP_OK) {
            if (plan->method != STP_METHOD_REFERENCE) /* transparent, and no atomics */
                check_plan(plan);
            again = plan_of(&in);
            char *first = stp_plan_print(plan), *second = stp_plan_print(again);
            assert_string_equal(first, second);
            free(first);
            free(second);
            made++;
        }
        assert_int_equal(log.lines, result != STP_OK);
        assert_true((plan == NULL) == (result != STP_OK));
        stp_plan_destroy(&plan);
        stp_plan_destroy(&again);
        release_inputs(&in);
    }
    assert_true(made > 1000);
}

/* Every splat in one pixel: the fixed-point sums of 64 bits hold it, without wasting a bit. */
static void test_sums_fit(void **state)
{
    for (int bits = 0; bits < 26; bits++) {
        struct inputs in = plain_inputs();
        color_inputs(&in);
        in.scene->facts.splats = (size_t)1 << bits;
        in.scene->facts.color_max = 65504;
        in.limits.heap_bytes = UINT64_C(1) << 33; /* room is not what is tested */
        struct stp_plan *plan = plan_of(&in);
        double most = (double)in.scene->facts.splats;
        assert_true(most * plan->frame.sum_scale < 0x1p63);
        assert_true(most * 65504 * plan->frame.color_scale < 0x1p63);
        assert_true(plan->frame.sum_scale == 0x1p40f || most * plan->frame.sum_scale >= 0x1p61);
        stp_plan_destroy(&plan);
        release_inputs(&in);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_random_plans),
                                        cmocka_unit_test(test_sums_fit) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
