/* The calls that may fail and what they may fail with, from the specification; and those that
 * cannot. A call that is in neither list is a misuse: it would be tested by nobody. */
#ifndef TEST_FAULT_CALLS_H
#define TEST_FAULT_CALLS_H

#define HOST   VK_ERROR_OUT_OF_HOST_MEMORY
#define MEMORY VK_ERROR_OUT_OF_DEVICE_MEMORY
#define LOST   VK_ERROR_DEVICE_LOST
#define INIT   VK_ERROR_INITIALIZATION_FAILED

/* Name, parameters, arguments, results. */
#define FAULT_PLAIN(X)                                                                             \
    X(vkEnumerateInstanceVersion, (uint32_t * a), (a), HOST)                                       \
    X(vkEnumerateInstanceLayerProperties, (uint32_t * a, VkLayerProperties * b), (a, b), HOST,     \
      MEMORY)                                                                                      \
    X(vkResetFences, (VkDevice a, uint32_t b, const VkFence *c), (a, b, c), MEMORY)                \
    X(vkResetCommandPool, (VkDevice a, VkCommandPool b, VkCommandPoolResetFlags c), (a, b, c),     \
      MEMORY)                                                                                      \
    X(vkAllocateCommandBuffers,                                                                    \
      (VkDevice a, const VkCommandBufferAllocateInfo *b, VkCommandBuffer *c), (a, b, c), HOST,     \
      MEMORY)                                                                                      \
    X(vkBeginCommandBuffer, (VkCommandBuffer a, const VkCommandBufferBeginInfo *b), (a, b), HOST,  \
      MEMORY)                                                                                      \
    X(vkEndCommandBuffer, (VkCommandBuffer a), (a), HOST, MEMORY)                                  \
    X(vkBindBufferMemory, (VkDevice a, VkBuffer b, VkDeviceMemory c, VkDeviceSize d),              \
      (a, b, c, d), HOST, MEMORY)                                                                  \
    X(vkBindImageMemory, (VkDevice a, VkImage b, VkDeviceMemory c, VkDeviceSize d), (a, b, c, d),  \
      HOST, MEMORY)                                                                                \
    X(vkMapMemory,                                                                                 \
      (VkDevice a, VkDeviceMemory b, VkDeviceSize c, VkDeviceSize d, VkMemoryMapFlags e,           \
       void **f),                                                                                  \
      (a, b, c, d, e, f), HOST, MEMORY, VK_ERROR_MEMORY_MAP_FAILED)                                \
    X(vkInvalidateMappedMemoryRanges, (VkDevice a, uint32_t b, const VkMappedMemoryRange *c),      \
      (a, b, c), HOST, MEMORY)                                                                     \
    X(vkAllocateDescriptorSets,                                                                    \
      (VkDevice a, const VkDescriptorSetAllocateInfo *b, VkDescriptorSet *c), (a, b, c), HOST,     \
      MEMORY, VK_ERROR_OUT_OF_POOL_MEMORY)                                                         \
    X(vkGetQueryPoolResults,                                                                       \
      (VkDevice a, VkQueryPool b, uint32_t c, uint32_t d, size_t e, void *f, VkDeviceSize g,       \
       VkQueryResultFlags h),                                                                      \
      (a, b, c, d, e, f, g, h), HOST, MEMORY, LOST)                                                \
    X(vkCreateDebugUtilsMessengerEXT,                                                              \
      (VkInstance a, const VkDebugUtilsMessengerCreateInfoEXT *b, const VkAllocationCallbacks *c,  \
       VkDebugUtilsMessengerEXT *d),                                                               \
      (a, b, c, d), HOST)

/* Object, results: vkCreateObject and vkDestroyObject of a device. */
#define FAULT_OBJECTS(X)                                                                           \
    X(Fence, HOST, MEMORY)                                                                         \
    X(CommandPool, HOST, MEMORY)                                                                   \
    X(Buffer, HOST, MEMORY)                                                                        \
    X(BufferView, HOST, MEMORY)                                                                    \
    X(Image, HOST, MEMORY)                                                                         \
    X(ImageView, HOST, MEMORY)                                                                     \
    X(Sampler, HOST, MEMORY)                                                                       \
    X(DescriptorSetLayout, HOST, MEMORY)                                                           \
    X(DescriptorPool, HOST, MEMORY)                                                                \
    X(PipelineLayout, HOST, MEMORY)                                                                \
    X(PipelineCache, HOST, MEMORY)                                                                 \
    X(ShaderModule, HOST, MEMORY)                                                                  \
    X(QueryPool, HOST, MEMORY)

#define FAULT_VOID(X)                                                                              \
    X(vkGetPhysicalDeviceProperties2)                                                              \
    X(vkGetPhysicalDeviceFeatures2)                                                                \
    X(vkGetPhysicalDeviceFormatProperties2)                                                        \
    X(vkGetPhysicalDeviceQueueFamilyProperties)                                                    \
    X(vkGetDeviceQueue)                                                                            \
    X(vkGetBufferDeviceAddress)                                                                    \
    X(vkGetDeviceBufferMemoryRequirements)                                                         \
    X(vkGetDeviceImageMemoryRequirements)                                                          \
    X(vkUnmapMemory)                                                                               \
    X(vkUpdateDescriptorSets)                                                                      \
    X(vkCmdResetQueryPool)                                                                         \
    X(vkCmdWriteTimestamp2)                                                                        \
    X(vkCmdPipelineBarrier2)                                                                       \
    X(vkCmdFillBuffer)                                                                             \
    X(vkCmdUpdateBuffer)                                                                           \
    X(vkCmdCopyBuffer)                                                                             \
    X(vkCmdCopyImage)                                                                              \
    X(vkCmdCopyBufferToImage)                                                                      \
    X(vkCmdCopyImageToBuffer)                                                                      \
    X(vkCmdBlitImage)                                                                              \
    X(vkCmdClearColorImage)                                                                        \
    X(vkCmdClearAttachments)                                                                       \
    X(vkCmdBindPipeline)                                                                           \
    X(vkCmdBindDescriptorSets)                                                                     \
    X(vkCmdBindIndexBuffer)                                                                        \
    X(vkCmdBindVertexBuffers)                                                                      \
    X(vkCmdPushConstants)                                                                          \
    X(vkCmdDispatch)                                                                               \
    X(vkCmdDispatchIndirect)                                                                       \
    X(vkCmdBeginRendering)                                                                         \
    X(vkCmdEndRendering)                                                                           \
    X(vkCmdSetViewport)                                                                            \
    X(vkCmdSetScissor)                                                                             \
    X(vkCmdDraw)                                                                                   \
    X(vkCmdDrawIndirect)                                                                           \
    X(vkCmdDrawIndexed)                                                                            \
    X(vkDestroyDebugUtilsMessengerEXT)

#endif
