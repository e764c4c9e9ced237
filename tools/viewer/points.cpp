#include "points.hpp"

// stipple has said why, in its one line on stderr.
static void check(stp_result result, const char *what)
{
    if (result != STP_OK)
        throw Failure(std::string(what) + ": " + stp_result_text(result));
}

static stp_render_params by(stp_method method, stp_path path)
{
    stp_render_params params = {};
    params.method = method;
    params.path = path;
    return params;
}

const std::array<Way, 4> Points::ways = { {
    { "exact", by(STP_METHOD_EXACT, STP_PATH_AUTO) },
    { "deferred", by(STP_METHOD_DEFERRED, STP_PATH_AUTO) },
    { "two-pass compute", by(STP_METHOD_TWO_PASS, STP_PATH_COMPUTE) },
    { "two-pass raster", by(STP_METHOD_TWO_PASS, STP_PATH_RASTER) },
} };

Points::Points(Device &device, const char *path) : device_(device)
{
    stp_scene *scene = nullptr;
    check(stp_scene_load(nullptr, path, nullptr, &scene), "loading");
    scene_.reset(scene);
    check(stp_scene_prepare(nullptr, scene, nullptr), "preparing");
    stp_import import = device.import();
    stp_context *context = nullptr;
    check(stp_context_import(nullptr, &import, &context), "importing the device");
    context_.reset(context);
}

void Points::choose(unsigned way, const stp_camera &largest, VkFormat color, VkFormat depth)
{
    device_.wait();
    const stp_render_params &params = ways[way].params;
    if (params.method == STP_METHOD_DEFERRED && !grouped_) {
        check(stp_scene_group(nullptr, scene_.get(), nullptr), "grouping");
        grouped_ = true;
    }
    stp_plan *plan = nullptr;
    check(stp_plan_create(nullptr, scene_.get(), &largest, &params,
                          stp_context_limits(context_.get()), &plan),
          "planning");
    for (Frame &frame : frames_)
        frame.reset();
    resident_.reset();
    plan_.reset(plan);
    stp_resident *resident = nullptr;
    check(stp_resident_create(nullptr, context_.get(), scene_.get(), plan, nullptr, &resident),
          "uploading");
    resident_.reset(resident);
    device_.run([&](VkCommandBuffer commands) {
        const uint32_t family = device_.import().queue_family;
        check(stp_resident_record_upload(nullptr, resident, commands, family), "uploading");
    });
    stp_resident_release_staging(resident);
    stp_host_frame_params wanted = {};
    wanted.color_format = color;
    wanted.depth_format = depth;
    wanted.depth_reversed = true;
    for (Frame &frame : frames_) {
        stp_frame *made = nullptr;
        check(stp_frame_create(nullptr, context_.get(), plan, &wanted, &made), "making a frame");
        frame.reset(made);
    }
}

void Points::record(unsigned frame, VkCommandBuffer commands, const stp_camera &camera,
                    const stp_targets &targets)
{
    check(stp_frame_record(nullptr, frames_[frame].get(), resident_.get(), &camera, &targets,
                           commands),
          "recording");
}

Picture Points::reference(const stp_camera &camera) const
{
    stp_plan *plan = nullptr;
    stp_image *image = nullptr;
    stp_limits limits;
    stp_limits_lavapipe(&limits);
    stp_render_params params = by(STP_METHOD_REFERENCE, STP_PATH_AUTO);
    check(stp_plan_create(nullptr, scene_.get(), &camera, &params, &limits, &plan), "planning");
    Plan owned(plan);
    check(stp_render(nullptr, nullptr, scene_.get(), plan, 0, &image, nullptr), "the reference");
    return Picture(image);
}
