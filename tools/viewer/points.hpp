// The points of the viewer, by stipple: one resident a method, frames in flight, and the reference.
#ifndef STIPPLE_VIEWER_POINTS_HPP
#define STIPPLE_VIEWER_POINTS_HPP

#include <array>
#include <memory>
#include <string>

#include "device.hpp"
#include <stipple/stipple.h>

// What stipple's functions made, destroyed by its functions.
template <typename T, void (*destroy)(T **)> struct Destroy {
    void operator()(T *object) const
    {
        destroy(&object);
    }
};
template <typename T, void (*destroy)(T **)> using Owned = std::unique_ptr<T, Destroy<T, destroy>>;
using Scene = Owned<stp_scene, stp_scene_destroy>;
using Plan = Owned<stp_plan, stp_plan_destroy>;
using Context = Owned<stp_context, stp_context_destroy>;
using Resident = Owned<stp_resident, stp_resident_destroy>;
using Frame = Owned<stp_frame, stp_frame_destroy>;
using Picture = Owned<stp_image, stp_image_destroy>;

// One way to draw the scene.
struct Way {
    const char *name;
    stp_render_params params;
};

class Points
{
  public:
    static const std::array<Way, 4> ways;

    Points(Device &device, const char *path);
    // Plans for pictures of this size, by this way; waits for what is being drawn.
    void choose(unsigned way, const stp_camera &largest, VkFormat color, VkFormat depth);
    void record(unsigned frame, VkCommandBuffer commands, const stp_camera &camera,
                const stp_targets &targets);
    // The float64 picture of the camera.
    Picture reference(const stp_camera &camera) const;
    const stp_scene *scene() const
    {
        return scene_.get();
    }

  private:
    Device &device_;
    Scene scene_;
    Context context_;
    Plan plan_;
    Resident resident_;
    std::array<Frame, Device::frames> frames_;
    bool grouped_ = false;
};

#endif
