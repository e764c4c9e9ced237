// The Vulkan half of the viewer: a window's device, swapchain, images and frames in flight. Knows
// nothing of points.
#ifndef STIPPLE_VIEWER_DEVICE_HPP
#define STIPPLE_VIEWER_DEVICE_HPP

#include <stdexcept>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <stipple/vulkan.h>

struct Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

inline void check(VkResult result, const char *call)
{
    if (result != VK_SUCCESS)
        throw Failure(std::string(call) + " failed: VkResult " + std::to_string(result));
}

struct Image {
    VkImage image = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkExtent2D size = {};
};

// Mapped memory that images are copied from and to.
struct Staging {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    void *mapped = nullptr;
    VkDeviceSize bytes = 0;
};

struct InFlight {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence done = VK_NULL_HANDLE;
    VkSemaphore acquired = VK_NULL_HANDLE;
};

class Device
{
  public:
    static constexpr unsigned frames = 2;

    Device(GLFWwindow *window, bool validate);
    ~Device();
    Device(const Device &) = delete;
    Device &operator=(const Device &) = delete;

    stp_import import() const;
    unsigned messages() const
    {
        return messages_;
    }
    VkDevice handle() const
    {
        return device_;
    }
    VkExtent2D size() const
    {
        return extent_;
    }

    Image make_image(VkFormat format, VkExtent2D size, VkImageUsageFlags usage);
    void destroy(Image &image);
    Staging make_staging(VkDeviceSize bytes);
    void destroy(Staging &staging);

    // Follows the window; false while it has no size.
    bool resize();
    // The next frame's commands, begun; null when the window changed under it.
    InFlight *begin();
    // Blits `picture`, which is in TRANSFER_SRC, to the window, submits and presents.
    void present(InFlight &frame, const Image &picture);
    // Commands that are run at once.
    template <typename Record> void run(Record record)
    {
        wait();
        InFlight &frame = in_flight_[0];
        restart(frame);
        record(frame.commands);
        submit(frame, false);
        wait();
    }
    void wait()
    {
        check(vkDeviceWaitIdle(device_), "vkDeviceWaitIdle");
    }
    void change(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect,
                VkImageLayout from, VkImageLayout to) const;

  private:
    void make_instance(bool validate);
    void choose();
    void make_device();
    void make_frames();
    void make_swapchain();
    void make_drawn(size_t count);
    void restart(InFlight &frame);
    void submit(InFlight &frame, bool to_window);
    uint32_t memory_type(uint32_t allowed, VkMemoryPropertyFlags flags) const;

    GLFWwindow *window_;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    uint32_t family_ = 0;
    stp_vulkan_features features_;
    VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
    VkExtent2D extent_ = {};
    std::vector<VkImage> images_;
    // One an image, not one a frame: a fence says nothing of when a presentation has waited.
    std::vector<VkSemaphore> drawn_;
    uint32_t image_ = 0;
    InFlight in_flight_[frames];
    unsigned next_ = 0;
    unsigned messages_ = 0;
};

#endif
