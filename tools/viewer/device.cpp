#include "device.hpp"

#include <algorithm>
#include <cstdio>

static VKAPI_ATTR VkBool32 VKAPI_CALL message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                              VkDebugUtilsMessageTypeFlagsEXT,
                                              const VkDebugUtilsMessengerCallbackDataEXT *data,
                                              void *user)
{
    ++*static_cast<unsigned *>(user);
    std::fprintf(stderr, "validation: %s\n", data->pMessage);
    return VK_FALSE;
}

Device::Device(GLFWwindow *window, bool validate) : window_(window)
{
    make_instance(validate);
    check(glfwCreateWindowSurface(instance_, window_, nullptr, &surface_), "making a surface");
    choose();
    make_device();
    make_frames();
}

Device::~Device()
{
    if (device_) {
        vkDeviceWaitIdle(device_);
        for (InFlight &f : in_flight_) {
            vkDestroySemaphore(device_, f.acquired, nullptr);
            vkDestroyFence(device_, f.done, nullptr);
            vkDestroyCommandPool(device_, f.pool, nullptr);
        }
        make_drawn(0);
        vkDestroySwapchainKHR(device_, swapchain_, nullptr);
        vkDestroyDevice(device_, nullptr);
    }
    if (surface_)
        vkDestroySurfaceKHR(instance_, surface_, nullptr);
    if (messenger_) {
        auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
            vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
        destroy(instance_, messenger_, nullptr);
    }
    if (instance_)
        vkDestroyInstance(instance_, nullptr);
}

void Device::make_instance(bool validate)
{
    uint32_t count = 0;
    const char **wanted = glfwGetRequiredInstanceExtensions(&count);
    if (!wanted)
        throw Failure("this display cannot show Vulkan");
    std::vector<const char *> extensions(wanted, wanted + count);
    if (validate)
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    const char *layer = "VK_LAYER_KHRONOS_validation";
    VkApplicationInfo application = {};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "stipple-view";
    application.apiVersion = VK_API_VERSION_1_3;
    VkInstanceCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &application;
    info.enabledLayerCount = validate ? 1 : 0;
    info.ppEnabledLayerNames = &layer;
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    check(vkCreateInstance(&info, nullptr, &instance_), "vkCreateInstance");
    if (!validate)
        return;
    VkDebugUtilsMessengerCreateInfoEXT messenger = {};
    messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                                VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = message;
    messenger.pUserData = &messages_;
    auto make = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
    check(make(instance_, &messenger, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT");
}

// The first device with a queue that draws, computes and presents.
void Device::choose()
{
    VkPhysicalDevice devices[16];
    uint32_t count = 16;
    VkResult result = vkEnumeratePhysicalDevices(instance_, &count, devices);
    if (result != VK_INCOMPLETE)
        check(result, "vkEnumeratePhysicalDevices");
    for (uint32_t i = 0; i < count; i++) {
        uint32_t families = 0;
        vkGetPhysicalDeviceQueueFamilyProperties(devices[i], &families, nullptr);
        std::vector<VkQueueFamilyProperties> properties(families);
        vkGetPhysicalDeviceQueueFamilyProperties(devices[i], &families, properties.data());
        for (uint32_t f = 0; f < families; f++) {
            const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
            VkBool32 presents = VK_FALSE;
            vkGetPhysicalDeviceSurfaceSupportKHR(devices[i], f, surface_, &presents);
            if (presents && (properties[f].queueFlags & both) == both) {
                physical_ = devices[i];
                family_ = f;
                return;
            }
        }
    }
    throw Failure("no Vulkan device draws to this window");
}

void Device::make_device()
{
    stp_vulkan_features supported;
    stp_vulkan_wanted_features(nullptr, &supported);
    vkGetPhysicalDeviceFeatures2(physical_, &supported.core);
    stp_vulkan_wanted_features(&supported, &features_);
    const char *extension = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue = {};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue.queueFamilyIndex = family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    info.pNext = &features_.core;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
    check(vkCreateDevice(physical_, &info, nullptr, &device_), "vkCreateDevice");
    vkGetDeviceQueue(device_, family_, 0, &queue_);
}

void Device::make_frames()
{
    for (InFlight &f : in_flight_) {
        VkCommandPoolCreateInfo pool = {};
        pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        pool.queueFamilyIndex = family_;
        check(vkCreateCommandPool(device_, &pool, nullptr, &f.pool), "vkCreateCommandPool");
        VkCommandBufferAllocateInfo info = {};
        info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
        info.commandPool = f.pool;
        info.commandBufferCount = 1;
        check(vkAllocateCommandBuffers(device_, &info, &f.commands), "vkAllocateCommandBuffers");
        VkFenceCreateInfo fence = {};
        fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
        fence.flags = VK_FENCE_CREATE_SIGNALED_BIT;
        check(vkCreateFence(device_, &fence, nullptr, &f.done), "vkCreateFence");
        VkSemaphoreCreateInfo semaphore = {};
        semaphore.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
        check(vkCreateSemaphore(device_, &semaphore, nullptr, &f.acquired), "vkCreateSemaphore");
    }
}

// In the place of those that there are; the device is idle.
void Device::make_drawn(size_t count)
{
    for (VkSemaphore s : drawn_)
        vkDestroySemaphore(device_, s, nullptr);
    drawn_.assign(count, VK_NULL_HANDLE);
    VkSemaphoreCreateInfo semaphore = {};
    semaphore.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
    for (VkSemaphore &s : drawn_)
        check(vkCreateSemaphore(device_, &semaphore, nullptr, &s), "vkCreateSemaphore");
}

static VkSurfaceFormatKHR choose_format(VkPhysicalDevice physical, VkSurfaceKHR surface)
{
    uint32_t count = 0;
    vkGetPhysicalDeviceSurfaceFormatsKHR(physical, surface, &count, nullptr);
    std::vector<VkSurfaceFormatKHR> formats(count);
    vkGetPhysicalDeviceSurfaceFormatsKHR(physical, surface, &count, formats.data());
    if (formats.empty())
        throw Failure("this window has no formats");
    for (const VkSurfaceFormatKHR &f : formats)
        if (f.format == VK_FORMAT_B8G8R8A8_SRGB || f.format == VK_FORMAT_R8G8B8A8_SRGB)
            return f;
    return formats[0];
}

void Device::make_swapchain()
{
    wait();
    VkSurfaceCapabilitiesKHR can;
    check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(physical_, surface_, &can),
          "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
    VkSwapchainKHR old = swapchain_;
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    extent_ = can.currentExtent;
    if (extent_.width == UINT32_MAX)
        extent_ = { static_cast<uint32_t>(width), static_cast<uint32_t>(height) };
    swapchain_ = VK_NULL_HANDLE;
    images_.clear();
    if (extent_.width && extent_.height) {
        VkSurfaceFormatKHR format = choose_format(physical_, surface_);
        VkSwapchainCreateInfoKHR info = {};
        info.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR;
        info.surface = surface_;
        info.minImageCount = can.maxImageCount ? std::min(can.minImageCount + 1, can.maxImageCount)
                                               : can.minImageCount + 1;
        info.imageFormat = format.format;
        info.imageColorSpace = format.colorSpace;
        info.imageExtent = extent_;
        info.imageArrayLayers = 1;
        info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        info.preTransform = can.currentTransform;
        info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
        info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
        info.clipped = VK_TRUE;
        info.oldSwapchain = old;
        check(vkCreateSwapchainKHR(device_, &info, nullptr, &swapchain_), "vkCreateSwapchainKHR");
        uint32_t count = 0;
        vkGetSwapchainImagesKHR(device_, swapchain_, &count, nullptr);
        images_.resize(count);
        check(vkGetSwapchainImagesKHR(device_, swapchain_, &count, images_.data()),
              "vkGetSwapchainImagesKHR");
    }
    make_drawn(images_.size());
    vkDestroySwapchainKHR(device_, old, nullptr);
}

stp_import Device::import() const
{
    stp_import import = {};
    import.get_instance_proc_addr = vkGetInstanceProcAddr;
    import.instance = instance_;
    import.physical_device = physical_;
    import.device = device_;
    import.queue_family = family_;
    import.api_version = VK_API_VERSION_1_3;
    import.features = &features_.core;
    return import;
}

uint32_t Device::memory_type(uint32_t allowed, VkMemoryPropertyFlags flags) const
{
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; i++)
        if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & flags) == flags)
            return i;
    throw Failure("no memory of a kind that the viewer needs");
}

Image Device::make_image(VkFormat format, VkExtent2D size, VkImageUsageFlags usage)
{
    Image made;
    made.format = format;
    made.size = size;
    const bool depth = (usage & VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT) != 0;
    VkImageCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = { size.width, size.height, 1 };
    info.mipLevels = info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = usage;
    check(vkCreateImage(device_, &info, nullptr, &made.image), "vkCreateImage");
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device_, made.image, &needs);
    VkMemoryAllocateInfo memory = {};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    memory.allocationSize = needs.size;
    memory.memoryTypeIndex = memory_type(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    check(vkAllocateMemory(device_, &memory, nullptr, &made.memory), "vkAllocateMemory");
    check(vkBindImageMemory(device_, made.image, made.memory, 0), "vkBindImageMemory");
    VkImageViewCreateInfo view = {};
    view.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    view.image = made.image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = format;
    view.subresourceRange = { static_cast<VkImageAspectFlags>(depth ? VK_IMAGE_ASPECT_DEPTH_BIT
                                                                    : VK_IMAGE_ASPECT_COLOR_BIT),
                              0, 1, 0, 1 };
    check(vkCreateImageView(device_, &view, nullptr, &made.view), "vkCreateImageView");
    return made;
}

void Device::destroy(Image &image)
{
    vkDestroyImageView(device_, image.view, nullptr);
    vkDestroyImage(device_, image.image, nullptr);
    vkFreeMemory(device_, image.memory, nullptr);
    image = Image();
}

Staging Device::make_staging(VkDeviceSize bytes)
{
    Staging made;
    made.bytes = bytes;
    VkBufferCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = bytes;
    info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    check(vkCreateBuffer(device_, &info, nullptr, &made.buffer), "vkCreateBuffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device_, made.buffer, &needs);
    VkMemoryAllocateInfo memory = {};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    memory.allocationSize = needs.size;
    memory.memoryTypeIndex =
        memory_type(needs.memoryTypeBits,
                    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(vkAllocateMemory(device_, &memory, nullptr, &made.memory), "vkAllocateMemory");
    check(vkBindBufferMemory(device_, made.buffer, made.memory, 0), "vkBindBufferMemory");
    check(vkMapMemory(device_, made.memory, 0, VK_WHOLE_SIZE, 0, &made.mapped), "vkMapMemory");
    return made;
}

void Device::destroy(Staging &staging)
{
    vkDestroyBuffer(device_, staging.buffer, nullptr);
    vkFreeMemory(device_, staging.memory, nullptr);
    staging = Staging();
}

void Device::restart(InFlight &frame)
{
    check(vkWaitForFences(device_, 1, &frame.done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
    check(vkResetFences(device_, 1, &frame.done), "vkResetFences");
    check(vkResetCommandPool(device_, frame.pool, 0), "vkResetCommandPool");
    VkCommandBufferBeginInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(frame.commands, &info), "vkBeginCommandBuffer");
}

bool Device::resize()
{
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    if (!swapchain_ || static_cast<uint32_t>(width) != extent_.width ||
        static_cast<uint32_t>(height) != extent_.height)
        make_swapchain();
    return swapchain_ != VK_NULL_HANDLE;
}

InFlight *Device::begin()
{
    InFlight &frame = in_flight_[next_];
    VkResult result = vkWaitForFences(device_, 1, &frame.done, VK_TRUE, UINT64_MAX);
    check(result, "vkWaitForFences");
    result = vkAcquireNextImageKHR(device_, swapchain_, UINT64_MAX, frame.acquired, VK_NULL_HANDLE,
                                   &image_);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) {
        make_swapchain();
        return nullptr;
    }
    if (result != VK_SUBOPTIMAL_KHR)
        check(result, "vkAcquireNextImageKHR");
    restart(frame);
    next_ = (next_ + 1) % frames;
    return &frame;
}

void Device::change(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect,
                    VkImageLayout from, VkImageLayout to) const
{
    VkImageMemoryBarrier2 barrier = {};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
    barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.image = image;
    barrier.subresourceRange = { aspect, 0, 1, 0, 1 };
    VkDependencyInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
    info.imageMemoryBarrierCount = 1;
    info.pImageMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &info);
}

void Device::submit(InFlight &frame, bool to_window)
{
    check(vkEndCommandBuffer(frame.commands), "vkEndCommandBuffer");
    VkCommandBufferSubmitInfo commands = {};
    commands.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
    commands.commandBuffer = frame.commands;
    VkSemaphoreSubmitInfo wait = {}, signal = {};
    wait.sType = signal.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
    wait.semaphore = frame.acquired;
    wait.stageMask = signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    signal.semaphore = to_window ? drawn_[image_] : VK_NULL_HANDLE;
    VkSubmitInfo2 info = {};
    info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
    info.waitSemaphoreInfoCount = info.signalSemaphoreInfoCount = to_window ? 1 : 0;
    info.pWaitSemaphoreInfos = &wait;
    info.pSignalSemaphoreInfos = &signal;
    info.commandBufferInfoCount = 1;
    info.pCommandBufferInfos = &commands;
    check(vkQueueSubmit2(queue_, 1, &info, frame.done), "vkQueueSubmit2");
}

void Device::present(InFlight &frame, const Image &picture)
{
    VkImage target = images_[image_];
    change(frame.commands, target, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkImageBlit blit = {};
    blit.srcSubresource = blit.dstSubresource = { VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1 };
    blit.srcOffsets[1] = { static_cast<int32_t>(picture.size.width),
                           static_cast<int32_t>(picture.size.height), 1 };
    blit.dstOffsets[1] = { static_cast<int32_t>(extent_.width),
                           static_cast<int32_t>(extent_.height), 1 };
    vkCmdBlitImage(frame.commands, picture.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
    change(frame.commands, target, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
           VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    submit(frame, true);
    VkPresentInfoKHR info = {};
    info.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR;
    info.waitSemaphoreCount = 1;
    info.pWaitSemaphores = &drawn_[image_];
    info.swapchainCount = 1;
    info.pSwapchains = &swapchain_;
    info.pImageIndices = &image_;
    VkResult result = vkQueuePresentKHR(queue_, &info);
    if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR)
        make_swapchain();
    else
        check(result, "vkQueuePresentKHR");
}
