// stipple-view: a window round a scene, and an example of a host in C++17 with GLM. The points are
// drawn by stipple between the viewer's own triangles.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "floor.hpp"
#include "points.hpp"

static const char usage[] =
    "usage: stipple-view SCENE [--size WxH] [--method NAME] [--frames N] [--save FILE.ppm] "
    "[--error]\n"
    "                    [--no-floor] [--validate]\n"
    "Drag to orbit, scroll to approach. M: the next method. E: error against the float64 "
    "reference,\n"
    "16 times enlarged. F: the floor. Esc: end. The title says the method and the milliseconds.\n"
    "--frames N ends after N frames, turning by a degree each; --save writes the last one.\n";

struct Settings {
    const char *scene = nullptr, *save = nullptr;
    int width = 960, height = 720;
    unsigned way = 0;
    long frames = 0;
    bool error = false, floor = true, validate = false;
};

static unsigned way_of(const char *name)
{
    for (unsigned i = 0; i < Points::ways.size(); i++)
        if (std::strcmp(Points::ways[i].name, name) == 0)
            return i;
    throw Failure(std::string("no method \"") + name + "\"");
}

static Settings parse(int argc, char **argv)
{
    Settings s;
    for (int i = 1; i < argc; i++) {
        const std::string a = argv[i];
        auto value = [&]() -> const char * {
            if (i + 1 == argc)
                throw Failure(a + " needs a value");
            return argv[++i];
        };
        if (a == "--size") {
            if (std::sscanf(value(), "%dx%d", &s.width, &s.height) != 2 || s.width < 1 ||
                s.height < 1)
                throw Failure("--size is WxH");
        } else if (a == "--method")
            s.way = way_of(value());
        else if (a == "--frames")
            s.frames = std::strtol(value(), nullptr, 10);
        else if (a == "--save")
            s.save = value();
        else if (a == "--error")
            s.error = true;
        else if (a == "--no-floor")
            s.floor = false;
        else if (a == "--validate")
            s.validate = true;
        else if (a == "--help" || a[0] == '-' || s.scene)
            throw Failure(usage);
        else
            s.scene = argv[i];
    }
    if (!s.scene)
        throw Failure(usage);
    return s;
}

// Where the eye is: around the middle of the scene.
struct Orbit {
    glm::dvec3 middle;
    double size = 1, distance = 1, azimuth = 0.6, elevation = 0.4;
    static constexpr double fov = 0.6;

    explicit Orbit(const stp_facts &facts)
    {
        const double *b = facts.bounds;
        const glm::dvec3 low(b[0], b[1], b[2]), high(b[3], b[4], b[5]);
        middle = 0.5 * (low + high);
        size = glm::length(high - low) / 2;
        distance = size / std::sin(fov / 2) * 1.05;
    }
    double near_plane() const
    {
        return distance * 1e-2;
    }
    glm::dmat4 view() const
    {
        const glm::dvec3 from(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                              std::cos(elevation) * std::cos(azimuth));
        return glm::lookAt(middle + distance * from, middle, glm::dvec3(0, 1, 0));
    }
    // Infinite far plane, reversed depth, y down: what Vulkan's clip space makes of stipple's.
    glm::dmat4 projection(double width, double height) const
    {
        const double f = 1 / std::tan(fov / 2);
        glm::dmat4 p(0);
        p[0][0] = f * height / width;
        p[1][1] = -f;
        p[3][2] = near_plane();
        p[2][3] = -1;
        return p;
    }
    stp_camera camera(uint32_t width, uint32_t height) const
    {
        stp_camera c = {};
        const glm::dmat4 m = view();
        for (int row = 0; row < 4; row++)
            for (int column = 0; column < 4; column++)
                c.world_to_camera[4 * row + column] = m[column][row];
        c.fx = c.fy = height / 2.0 / std::tan(fov / 2);
        c.cx = width / 2.0;
        c.cy = height / 2.0;
        c.width = width;
        c.height = height;
        c.near_depth = near_plane();
        c.far_depth = INFINITY;
        return c;
    }
};

class Viewer
{
  public:
    Viewer(GLFWwindow *window, const Settings &settings)
        : window_(window), settings_(settings), device_(window, settings.validate),
          points_(device_, settings.scene), orbit_(*stp_scene_facts(points_.scene())),
          floor_(device_.handle(), color_format, depth_format)
    {
        glfwSetWindowUserPointer(window, this);
        glfwSetKeyCallback(window, [](GLFWwindow *w, int key, int, int action, int) {
            if (action == GLFW_PRESS)
                static_cast<Viewer *>(glfwGetWindowUserPointer(w))->key(key);
        });
        glfwSetScrollCallback(window, [](GLFWwindow *w, double, double y) {
            static_cast<Viewer *>(glfwGetWindowUserPointer(w))->orbit_.distance *=
                std::exp(-0.1 * y);
        });
        glfwSetCursorPosCallback(window, [](GLFWwindow *w, double x, double y) {
            static_cast<Viewer *>(glfwGetWindowUserPointer(w))->drag(x, y);
        });
    }
    ~Viewer()
    {
        device_.wait();
        release();
    }
    Viewer(const Viewer &) = delete;
    Viewer &operator=(const Viewer &) = delete;

    void run()
    {
        for (long n = 0; !glfwWindowShouldClose(window_); n++) {
            glfwPollEvents();
            if (draw() && settings_.frames && n + 1 >= settings_.frames)
                break;
            if (settings_.frames)
                orbit_.azimuth += 0.0174532925;
        }
        if (settings_.save)
            save();
        std::printf("%s: %.1f ms a frame\n", Points::ways[settings_.way].name, milliseconds_);
    }
    unsigned messages() const
    {
        return device_.messages();
    }

  private:
    static constexpr VkFormat color_format = VK_FORMAT_R32G32B32A32_SFLOAT;
    static constexpr VkFormat depth_format = VK_FORMAT_D32_SFLOAT;

    void key(int key)
    {
        if (key == GLFW_KEY_ESCAPE)
            glfwSetWindowShouldClose(window_, GLFW_TRUE);
        if (key == GLFW_KEY_M) {
            settings_.way = (settings_.way + 1) % static_cast<unsigned>(Points::ways.size());
            release();
        }
        if (key == GLFW_KEY_E)
            settings_.error = !settings_.error;
        if (key == GLFW_KEY_F)
            settings_.floor = !settings_.floor;
    }
    void drag(double x, double y)
    {
        if (glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS) {
            orbit_.azimuth -= 0.008 * (x - x_);
            orbit_.elevation = glm::clamp(orbit_.elevation + 0.008 * (y - y_), -1.55, 1.55);
        }
        x_ = x;
        y_ = y;
    }
    void release()
    {
        device_.wait();
        if (!color_.image)
            return;
        device_.destroy(color_);
        device_.destroy(depth_);
        device_.destroy(staging_);
    }
    void prepare(VkExtent2D size)
    {
        if (color_.image && color_.size.width == size.width && color_.size.height == size.height)
            return;
        release();
        color_ = device_.make_image(color_format, size,
                                    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                        VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                        VK_IMAGE_USAGE_TRANSFER_DST_BIT);
        depth_ =
            device_.make_image(depth_format, size, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
        staging_ = device_.make_staging(VkDeviceSize(16) * size.width * size.height);
        points_.choose(settings_.way, orbit_.camera(size.width, size.height), color_format,
                       depth_format);
    }
    void draw_floor(VkCommandBuffer commands)
    {
        VkRenderingAttachmentInfo color = {}, depth = {};
        color.sType = depth.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
        color.imageView = color_.view;
        color.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        depth.imageView = depth_.view;
        depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        color.loadOp = depth.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        color.storeOp = depth.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        if (!settings_.error)
            color.clearValue.color = { { 0.02f, 0.025f, 0.03f, 1 } };
        VkRect2D area = { { 0, 0 }, color_.size };
        VkRenderingInfo rendering = {};
        rendering.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
        rendering.renderArea = area;
        rendering.layerCount = 1;
        rendering.colorAttachmentCount = 1;
        rendering.pColorAttachments = &color;
        rendering.pDepthAttachment = &depth;
        VkViewport viewport = { 0, 0, float(color_.size.width), float(color_.size.height), 0, 1 };
        vkCmdBeginRendering(commands, &rendering);
        vkCmdSetViewport(commands, 0, 1, &viewport);
        vkCmdSetScissor(commands, 0, 1, &area);
        if (settings_.floor && !settings_.error) {
            glm::dmat4 place =
                glm::translate(glm::dmat4(1), orbit_.middle - glm::dvec3(0, 0.3 * orbit_.size, 0));
            place = glm::scale(place, glm::dvec3(1.3 * orbit_.size));
            floor_.draw(commands,
                        glm::mat4(orbit_.projection(color_.size.width, color_.size.height) *
                                  orbit_.view() * place));
        }
        vkCmdEndRendering(commands);
    }
    void record(VkCommandBuffer commands)
    {
        device_.change(commands, color_.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                       VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        device_.change(commands, depth_.image, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                       VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
        draw_floor(commands);
        stp_targets targets = {};
        targets.color = { color_.image,
                          color_.view,
                          VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                          0,
                          0 };
        targets.depth = { depth_.image,
                          depth_.view,
                          VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                          VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                          0,
                          0 };
        targets.width = color_.size.width;
        targets.height = color_.size.height;
        targets.depth_near = orbit_.near_plane();
        targets.depth_far = INFINITY;
        points_.record(frame_, commands, orbit_.camera(color_.size.width, color_.size.height),
                       targets);
        frame_ = (frame_ + 1) % Device::frames;
    }
    // The picture on the host, and back again.
    void copy(bool to_host)
    {
        device_.run([&](VkCommandBuffer commands) {
            const VkImageLayout layout = to_host ? VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL
                                                 : VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
            VkBufferImageCopy region = {};
            region.imageSubresource = { VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1 };
            region.imageExtent = { color_.size.width, color_.size.height, 1 };
            if (to_host) {
                vkCmdCopyImageToBuffer(commands, color_.image, layout, staging_.buffer, 1, &region);
                return;
            }
            device_.change(commands, color_.image, VK_IMAGE_ASPECT_COLOR_BIT,
                           VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout);
            vkCmdCopyBufferToImage(commands, staging_.buffer, color_.image, layout, 1, &region);
            device_.change(commands, color_.image, VK_IMAGE_ASPECT_COLOR_BIT, layout,
                           VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        });
    }
    // Replaces the picture by its error: 16 times |picture - reference|, from black over red to
    // white.
    void overlay()
    {
        device_.run([&](VkCommandBuffer commands) { record(commands); });
        copy(true);
        Picture truth = points_.reference(orbit_.camera(color_.size.width, color_.size.height));
        const char *const names[] = { "R", "G", "B" };
        float *texel = static_cast<float *>(staging_.mapped);
        const size_t count = size_t(color_.size.width) * color_.size.height;
        for (size_t i = 0; i < count; i++, texel += 4) {
            float error = 0;
            for (int k = 0; k < 3; k++) {
                const stp_channel *c = stp_image_find(truth.get(), names[k]);
                error = std::max(error, std::fabs(texel[k] - c->data.f[i]));
            }
            const float heat = 16 * error;
            texel[0] = glm::clamp(2 * heat, 0.f, 1.f);
            texel[1] = texel[2] = glm::clamp(2 * heat - 1, 0.f, 1.f);
        }
        copy(false);
    }
    bool draw()
    {
        const auto start = std::chrono::steady_clock::now();
        if (!device_.resize())
            return false;
        prepare(device_.size());
        if (settings_.error)
            overlay();
        InFlight *frame = device_.begin();
        if (!frame)
            return false;
        if (!settings_.error)
            record(frame->commands);
        device_.present(*frame, color_);
        show_time(std::chrono::steady_clock::now() - start);
        return true;
    }
    void show_time(std::chrono::duration<double, std::milli> took)
    {
        milliseconds_ = milliseconds_ > 0 ? 0.9 * milliseconds_ + 0.1 * took.count() : took.count();
        char title[128];
        std::snprintf(title, sizeof title, "stipple-view: %s%s, %.1f ms",
                      Points::ways[settings_.way].name, settings_.error ? ", error x 16" : "",
                      milliseconds_);
        glfwSetWindowTitle(window_, title);
    }
    void save()
    {
        FILE *file = std::fopen(settings_.save, "wb");
        if (!file)
            throw Failure(std::string(settings_.save) + ": cannot be written");
        copy(true);
        const float *texel = static_cast<const float *>(staging_.mapped);
        std::fprintf(file, "P6\n%u %u\n255\n", color_.size.width, color_.size.height);
        const size_t count = size_t(color_.size.width) * color_.size.height;
        for (size_t i = 0; i < count; i++)
            for (int k = 0; k < 3; k++) {
                const float v = glm::clamp(texel[4 * i + size_t(k)], 0.f, 1.f);
                const float s =
                    v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
                std::fputc(int(255 * s + 0.5f), file);
            }
        if (std::fclose(file) != 0)
            throw Failure(std::string(settings_.save) + ": writing failed");
    }

    GLFWwindow *window_;
    Settings settings_;
    Device device_;
    Points points_;
    Orbit orbit_;
    Floor floor_;
    Image color_, depth_;
    Staging staging_;
    unsigned frame_ = 0;
    double x_ = 0, y_ = 0, milliseconds_ = 0;
};

static int view(const Settings &settings)
{
    if (!glfwInit())
        throw Failure("there is no display to open a window on");
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    GLFWwindow *window =
        glfwCreateWindow(settings.width, settings.height, "stipple-view", nullptr, nullptr);
    if (!window)
        throw Failure("no window could be opened");
    unsigned messages = 0;
    {
        Viewer viewer(window, settings);
        viewer.run();
        messages = viewer.messages();
    }
    glfwDestroyWindow(window);
    if (messages)
        throw Failure(std::to_string(messages) + " validation messages");
    return EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    int status = EXIT_FAILURE;
    try {
        status = view(parse(argc, argv));
    } catch (const std::exception &failure) {
        std::fprintf(stderr, "stipple-view: %s\n", failure.what());
    }
    glfwTerminate();
    return status;
}
