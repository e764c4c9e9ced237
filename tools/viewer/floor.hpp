// Triangles of the viewer's own, to stand between points: a chequered floor.
#ifndef STIPPLE_VIEWER_FLOOR_HPP
#define STIPPLE_VIEWER_FLOOR_HPP

#include <glm/glm.hpp>

#include "device.hpp"

class Floor
{
  public:
    Floor(VkDevice device, VkFormat color, VkFormat depth);
    ~Floor();
    Floor(const Floor &) = delete;
    Floor &operator=(const Floor &) = delete;
    // Within rendering to both; depth is reversed. clip: from the unit square to clip space.
    void draw(VkCommandBuffer commands, const glm::mat4 &clip) const;

  private:
    VkDevice device_;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
};

#endif
