/* Layers of a deep picture, as they come: of any pixel in any order, of one pixel from the front.
 */
#ifndef STP_SCENE_DEEP_H
#define STP_SCENE_DEEP_H

#include <stipple/image.h>

struct deep_entry {
    uint32_t pixel; /* rows from the top */
    struct stp_deep_layer layer;
};

/* Zero: empty. Grows as it is filled; one thread's. */
struct deep_list {
    struct deep_entry *entry;
    size_t count, room;
};

/* STP_ERROR_MEMORY, unlogged: it is called from threads that may not log. */
enum stp_result deep_add(struct deep_list *list, uint32_t pixel,
                         const struct stp_deep_layer *layer);
void deep_list_release(struct deep_list *list);

/* All of the lists, sorted by pixel; layers of a pixel, which must be in one list, keep their
 * order. */
enum stp_result deep_build(const struct stp_env *env, const struct deep_list *lists, unsigned count,
                           size_t pixels, struct stp_deep **deep);
void deep_destroy(struct stp_deep **deep);

#endif
