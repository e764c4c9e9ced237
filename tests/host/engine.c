#include "engine.h"

#include "triangle_frag.h"
#include "triangle_vert.h"

#define LEAST ((VkDeviceSize)1 << 20) /* best practice: no small allocations */
#define STAGES                                                                                     \
    (VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT |      \
     VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT |                                                 \
     VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT)
#define CHECK(call) assert_int_equal(call, VK_SUCCESS)

static void keep_line(void *user, enum stp_log_level level, const char *line)
{
    struct engine *e = user;
    if (level == STP_LOG_INFO)
        return;
    e->lines++;
    snprintf(e->last, sizeof e->last, "%s", line);
}

static VKAPI_ATTR VkBool32 VKAPI_CALL message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                              VkDebugUtilsMessageTypeFlagsEXT types,
                                              const VkDebugUtilsMessengerCallbackDataEXT *data,
                                              void *user)
{
    struct engine *e = user;
    e->messages++;

    snprintf(e->last, sizeof e->last, "%s", data->pMessage);
    return VK_FALSE;
}

static void make_instance(struct engine *e, bool validate)
{
    const char *layer = "VK_LAYER_KHRONOS_validation";
    const char *extensions[] = { VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                 VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME };
    VkValidationFeatureEnableEXT enabled[] = {
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT,
        VK_VALIDATION_FEATURE_ENABLE_BEST_PRACTICES_EXT
    };
    VkDebugUtilsMessengerCreateInfoEXT messenger = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = message,
        .pUserData = e,
    };
    VkValidationFeaturesEXT validation = { .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                           .enabledValidationFeatureCount = 2,
                                           .pEnabledValidationFeatures = enabled };
    VkApplicationInfo application = { .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                      .pApplicationName = "engine",
                                      .apiVersion = VK_API_VERSION_1_3 };
    VkInstanceCreateInfo info = { .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                  .pNext = validate ? &validation : NULL,
                                  .pApplicationInfo = &application,
                                  .enabledLayerCount = validate ? 1 : 0,
                                  .ppEnabledLayerNames = &layer,
                                  .enabledExtensionCount = validate ? 2 : 0,
                                  .ppEnabledExtensionNames = extensions };
    CHECK(vkCreateInstance(&info, NULL, &e->instance));
    if (!validate)
        return;
    PFN_vkCreateDebugUtilsMessengerEXT make =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(e->instance,
                                                                  "vkCreateDebugUtilsMessengerEXT");
    CHECK(make(e->instance, &messenger, NULL, &e->messenger));
}

/* Turns recommended features off by their names. */
static void mask(struct engine *e, const char *masked)
{
    if (!masked)
        return;
    if (strstr(masked, "shaderBufferInt64Atomics"))
        e->features.v12.shaderBufferInt64Atomics = VK_FALSE;
    if (strstr(masked, "shaderOutputLayer"))
        e->features.v12.shaderOutputLayer = VK_FALSE;
    if (strstr(masked, "shaderFloat64"))
        e->features.core.features.shaderFloat64 = VK_FALSE;
    if (strstr(masked, "synchronization2"))
        e->features.v13.synchronization2 = VK_FALSE;
    if (strstr(masked, "scalarBlockLayout"))
        e->features.v12.scalarBlockLayout = VK_FALSE;
}

static void make_device(struct engine *e, const char *masked)
{
    struct stp_vulkan_features supported;
    uint32_t count = 1;
    VkResult found = vkEnumeratePhysicalDevices(e->instance, &count, &e->physical);
    assert_true(found == VK_SUCCESS || found == VK_INCOMPLETE);
    stp_vulkan_wanted_features(NULL, &supported); /* for its chain */
    vkGetPhysicalDeviceFeatures2(e->physical, &supported.core);
    stp_vulkan_wanted_features(&supported, &e->features);
    mask(e, masked);
    float priority = 1;
    VkDeviceQueueCreateInfo queue = { .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                      .queueFamilyIndex = 0,
                                      .queueCount = 1,
                                      .pQueuePriorities = &priority };
    VkDeviceCreateInfo info = { .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                .pNext = &e->features.core,
                                .queueCreateInfoCount = 1,
                                .pQueueCreateInfos = &queue };
    CHECK(vkCreateDevice(e->physical, &info, NULL, &e->device));
    vkGetDeviceQueue(e->device, 0, 0, &e->queue);
}

static void make_commands(struct engine *e)
{
    for (int i = 0; i < ENGINE_FRAMES; i++) {
        VkCommandPoolCreateInfo pool = { .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO };
        CHECK(vkCreateCommandPool(e->device, &pool, NULL, &e->pool[i]));
        VkCommandBufferAllocateInfo info = { .sType =
                                                 VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                             .commandPool = e->pool[i],
                                             .commandBufferCount = 1 };
        CHECK(vkAllocateCommandBuffers(e->device, &info, &e->commands[i]));
    }
    VkFenceCreateInfo fence = { .sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO,
                                .flags = VK_FENCE_CREATE_SIGNALED_BIT };
    for (int i = 0; i < ENGINE_FRAMES; i++)
        CHECK(vkCreateFence(e->device, &fence, NULL, &e->fence[i]));
    VkPushConstantRange push = { VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                                 sizeof(struct engine_triangle) };
    VkPipelineLayoutCreateInfo layout = { .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .pushConstantRangeCount = 1,
                                          .pPushConstantRanges = &push };
    CHECK(vkCreatePipelineLayout(e->device, &layout, NULL, &e->layout));
}

void engine_open(struct engine *e, const char *masked)
{
    *e = (struct engine){ .env = { .threads = 2, .log = keep_line, .user = e } };
    make_instance(e, !masked || !strstr(masked, "validation"));
    make_device(e, masked);
    make_commands(e);
}

void engine_close(struct engine *e)
{
    engine_finish(e);
    vkDestroyPipelineLayout(e->device, e->layout, NULL);
    for (int i = 0; i < ENGINE_FRAMES; i++) {
        vkDestroyFence(e->device, e->fence[i], NULL);
        vkDestroyCommandPool(e->device, e->pool[i], NULL);
    }
    vkDestroyDevice(e->device, NULL);
    if (e->messages)
        fail_msg("%u validation messages, the last: %s", e->messages, e->last);
    if (e->messenger) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy =
            (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
                e->instance, "vkDestroyDebugUtilsMessengerEXT");
        destroy(e->instance, e->messenger, NULL);
    }
    vkDestroyInstance(e->instance, NULL);
}

struct stp_import engine_import(const struct engine *e)
{
    return (struct stp_import){ .get_instance_proc_addr = vkGetInstanceProcAddr,
                                .instance = e->instance,
                                .physical_device = e->physical,
                                .device = e->device,
                                .queue_family = e->family,
                                .api_version = VK_API_VERSION_1_3,
                                .features = &e->features.core };
}

struct stp_context *engine_context(struct engine *e)
{
    struct stp_context *context = NULL;
    struct stp_import import = engine_import(e);
    if (stp_context_import(&e->env, &import, &context) != STP_OK)
        fail_msg("no context: %s", e->last);
    return context;
}

static uint32_t device_memory(struct engine *e, uint32_t allowed, VkMemoryPropertyFlags flags)
{
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(e->physical, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; i++)
        if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & flags) == flags)
            return i;
    fail_msg("no memory type");
    return 0;
}

static VkImageView make_view(struct engine *e, const struct engine_image *image)
{
    VkImageView view;
    VkImageViewCreateInfo info = { .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = image->image,
                                   .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                   .format = image->format,
                                   .subresourceRange = { image->aspects, 0, 1, 0, 1 } };
    CHECK(vkCreateImageView(e->device, &info, NULL, &view));
    return view;
}

static VkImageAspectFlags aspects_of(VkFormat format)
{
    switch (format) {
    case VK_FORMAT_D32_SFLOAT:
    case VK_FORMAT_D16_UNORM:
    case VK_FORMAT_X8_D24_UNORM_PACK32:
        return VK_IMAGE_ASPECT_DEPTH_BIT;
    case VK_FORMAT_D24_UNORM_S8_UINT:
    case VK_FORMAT_D32_SFLOAT_S8_UINT:
        return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
    default:
        return VK_IMAGE_ASPECT_COLOR_BIT;
    }
}

void engine_image_open(struct engine *e, VkFormat format, uint32_t width, uint32_t height,
                       struct engine_image *image)
{
    *image = (struct engine_image){
        .format = format, .aspects = aspects_of(format), .width = width, .height = height
    };
    bool color = image->aspects == VK_IMAGE_ASPECT_COLOR_BIT;
    VkImageCreateInfo info = { .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = format,
                               .extent = { width, height, 1 },
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                        VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                        (color ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT
                                               : VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT) };
    VkMemoryRequirements needs;
    CHECK(vkCreateImage(e->device, &info, NULL, &image->image));
    vkGetImageMemoryRequirements(e->device, image->image, &needs);
    VkMemoryAllocateInfo memory = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                    .allocationSize = needs.size + LEAST,
                                    .memoryTypeIndex = device_memory(e, needs.memoryTypeBits, 0) };
    CHECK(vkAllocateMemory(e->device, &memory, NULL, &image->memory));
    CHECK(vkBindImageMemory(e->device, image->image, image->memory, 0));
    image->view = make_view(e, image);
}

void engine_image_close(struct engine *e, struct engine_image *image)
{
    vkDestroyImageView(e->device, image->view, NULL);
    vkDestroyImage(e->device, image->image, NULL);
    vkFreeMemory(e->device, image->memory, NULL);
    *image = (struct engine_image){ 0 };
}

struct stp_host_image engine_target(const struct engine_image *image)
{
    return (struct stp_host_image){ .image = image->image,
                                    .view = image->view,
                                    .before = VK_IMAGE_LAYOUT_GENERAL,
                                    .after = VK_IMAGE_LAYOUT_GENERAL };
}

static VkAccessFlags2 access_in(VkImageLayout layout)
{
    if (layout == VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL)
        return VK_ACCESS_2_TRANSFER_READ_BIT;
    if (layout == VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL)
        return VK_ACCESS_2_TRANSFER_WRITE_BIT;
    return layout == VK_IMAGE_LAYOUT_UNDEFINED
               ? 0
               : VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
}

static void wait_for_all(VkCommandBuffer commands, const struct engine_image *image,
                         VkImageLayout from, VkImageLayout to)
{
    VkImageMemoryBarrier2 barrier = { .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                      .srcStageMask = STAGES,
                                      .srcAccessMask = access_in(from),
                                      .dstStageMask = STAGES,
                                      .dstAccessMask = access_in(to),
                                      .oldLayout = from,
                                      .newLayout = to,
                                      .image = image->image,
                                      .subresourceRange = { image->aspects, 0, 1, 0, 1 } };
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .imageMemoryBarrierCount = 1,
                              .pImageMemoryBarriers = &barrier };
    vkCmdPipelineBarrier2(commands, &info);
}

void engine_clear(VkCommandBuffer commands, const struct engine_image *image,
                  const VkClearValue *value)
{
    VkImageSubresourceRange range = { image->aspects, 0, 1, 0, 1 };
    const VkImageLayout layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    wait_for_all(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, layout);
    if (image->aspects == VK_IMAGE_ASPECT_COLOR_BIT)
        vkCmdClearColorImage(commands, image->image, layout, &value->color, 1, &range);
    else
        vkCmdClearDepthStencilImage(commands, image->image, layout, &value->depthStencil, 1,
                                    &range);
    wait_for_all(commands, image, layout, VK_IMAGE_LAYOUT_GENERAL);
}

VkCommandBuffer engine_begin(struct engine *e, unsigned i)
{
    CHECK(vkWaitForFences(e->device, 1, &e->fence[i], VK_TRUE, UINT64_MAX));
    CHECK(vkResetFences(e->device, 1, &e->fence[i]));
    CHECK(vkResetCommandPool(e->device, e->pool[i], 0));
    VkCommandBufferBeginInfo info = { .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT };
    CHECK(vkBeginCommandBuffer(e->commands[i], &info));
    return e->commands[i];
}

void engine_submit(struct engine *e, unsigned i)
{
    CHECK(vkEndCommandBuffer(e->commands[i]));
    VkCommandBufferSubmitInfo commands = { .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                           .commandBuffer = e->commands[i] };
    VkSubmitInfo2 info = { .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                           .commandBufferInfoCount = 1,
                           .pCommandBufferInfos = &commands };
    CHECK(vkQueueSubmit2(e->queue, 1, &info, e->fence[i]));
}

void engine_finish(struct engine *e)
{
    CHECK(vkWaitForFences(e->device, ENGINE_FRAMES, e->fence, VK_TRUE, UINT64_MAX));
}

/* A mapped buffer that a copy fills. */
struct copied {
    VkBuffer buffer;
    VkDeviceMemory memory;
    void *mapped;
};

static struct copied make_copied(struct engine *e, VkDeviceSize bytes)
{
    struct copied c;
    VkBufferCreateInfo info = { .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = bytes,
                                .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT };
    VkMemoryRequirements needs;
    CHECK(vkCreateBuffer(e->device, &info, NULL, &c.buffer));
    vkGetBufferMemoryRequirements(e->device, c.buffer, &needs);
    uint32_t type =
        device_memory(e, needs.memoryTypeBits,
                      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VkMemoryAllocateInfo memory = { .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                    .allocationSize = needs.size + LEAST,
                                    .memoryTypeIndex = type };
    CHECK(vkAllocateMemory(e->device, &memory, NULL, &c.memory));
    CHECK(vkBindBufferMemory(e->device, c.buffer, c.memory, 0));
    CHECK(vkMapMemory(e->device, c.memory, 0, VK_WHOLE_SIZE, 0, &c.mapped));
    return c;
}

void *engine_read(struct engine *e, const struct engine_image *image, size_t texel)
{
    size_t bytes = (size_t)image->width * image->height * texel;
    struct copied c = make_copied(e, bytes);
    engine_finish(e);
    VkCommandBuffer commands = engine_begin(e, 0);
    wait_for_all(commands, image, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VkImageAspectFlags aspect = image->aspects & VK_IMAGE_ASPECT_COLOR_BIT
                                    ? VK_IMAGE_ASPECT_COLOR_BIT
                                    : VK_IMAGE_ASPECT_DEPTH_BIT;
    VkBufferImageCopy copy = { .imageSubresource = { aspect, 0, 0, 1 },
                               .imageExtent = { image->width, image->height, 1 } };
    vkCmdCopyImageToBuffer(commands, image->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, c.buffer,
                           1, &copy);
    wait_for_all(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL);
    engine_submit(e, 0);
    engine_finish(e);
    void *texels = malloc(bytes);
    assert_non_null(texels);
    memcpy(texels, c.mapped, bytes);
    vkDestroyBuffer(e->device, c.buffer, NULL);
    vkFreeMemory(e->device, c.memory, NULL);
    return texels;
}

static VkShaderModule module(struct engine *e, const uint32_t *words, size_t bytes)
{
    VkShaderModule made;
    VkShaderModuleCreateInfo info = { .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                      .codeSize = bytes,
                                      .pCode = words };
    CHECK(vkCreateShaderModule(e->device, &info, NULL, &made));
    return made;
}

static VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits which, VkShaderModule shader)
{
    return (VkPipelineShaderStageCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
        .stage = which,
        .module = shader,
        .pName = "main"
    };
}

static VkPipeline make_pipeline(struct engine *e, const VkPipelineRenderingCreateInfo *rendering,
                                const VkPipelineShaderStageCreateInfo *stages, bool reversed)
{
    VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO
    };
    VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST
    };
    VkPipelineViewportStateCreateInfo viewport = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .scissorCount = 1
    };
    VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1
    };
    VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT
    };
    VkPipelineDepthStencilStateCreateInfo depth = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = VK_TRUE,
        .depthWriteEnable = VK_TRUE,
        .depthCompareOp = reversed ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_LESS
    };
    VkPipelineColorBlendAttachmentState opaque = { .colorWriteMask = 0xf };
    VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = 1,
        .pAttachments = &opaque
    };
    VkDynamicState moving[] = { VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR };
    VkPipelineDynamicStateCreateInfo dynamic = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
        .dynamicStateCount = 2,
        .pDynamicStates = moving
    };
    VkGraphicsPipelineCreateInfo info = { .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = rendering,
                                          .stageCount = 2,
                                          .pStages = stages,
                                          .pVertexInputState = &input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport,
                                          .pRasterizationState = &raster,
                                          .pMultisampleState = &samples,
                                          .pDepthStencilState = &depth,
                                          .pColorBlendState = &blend,
                                          .pDynamicState = &dynamic,
                                          .layout = e->layout };
    VkPipeline pipeline;
    CHECK(vkCreateGraphicsPipelines(e->device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline));
    return pipeline;
}

VkPipeline engine_pipeline(struct engine *e, VkFormat color, VkFormat depth, bool reversed)
{
    VkShaderModule vertex = module(e, triangle_vert, sizeof triangle_vert);
    VkShaderModule fragment = module(e, triangle_frag, sizeof triangle_frag);
    VkPipelineShaderStageCreateInfo stages[] = { stage(VK_SHADER_STAGE_VERTEX_BIT, vertex),
                                                 stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment) };
    VkPipelineRenderingCreateInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .colorAttachmentCount = 1,
        .pColorAttachmentFormats = &color,
        .depthAttachmentFormat = depth
    };
    VkPipeline pipeline = make_pipeline(e, &rendering, stages, reversed);
    vkDestroyShaderModule(e->device, vertex, NULL);
    vkDestroyShaderModule(e->device, fragment, NULL);
    return pipeline;
}

static VkRenderingAttachmentInfo attachment(const struct engine_image *image)
{
    return (VkRenderingAttachmentInfo){ .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                        .imageView = image->view,
                                        .imageLayout = VK_IMAGE_LAYOUT_GENERAL,
                                        .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                        .storeOp = VK_ATTACHMENT_STORE_OP_STORE };
}

void engine_draw(struct engine *e, VkCommandBuffer commands, VkPipeline pipeline,
                 const struct engine_image *color, const struct engine_image *depth,
                 const struct engine_triangle *triangle)
{
    VkRenderingAttachmentInfo attachments[] = { attachment(color), attachment(depth) };
    VkRect2D area = { .extent = { color->width, color->height } };
    VkRenderingInfo rendering = { .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = area,
                                  .layerCount = 1,
                                  .colorAttachmentCount = 1,
                                  .pColorAttachments = &attachments[0],
                                  .pDepthAttachment = &attachments[1] };
    VkViewport viewport = { 0, 0, (float)color->width, (float)color->height, 0, 1 };
    vkCmdBeginRendering(commands, &rendering);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &area);
    vkCmdPushConstants(commands, e->layout,
                       VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                       sizeof *triangle, triangle);
    vkCmdDraw(commands, 3, 1, 0, 0);
    vkCmdEndRendering(commands);
    wait_for_all(commands, color, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL);
    wait_for_all(commands, depth, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL);
}
