#include "scene/deep.h"

#include "base/log.h"
#include "base/memory.h"

#define LEAST_ROOM 4096

enum stp_result deep_add(struct deep_list *list, uint32_t pixel, const struct stp_deep_layer *layer)
{
    if (list->count == list->room) {
        size_t room = list->room ? 2 * list->room : LEAST_ROOM;
        struct deep_entry *entry = mem_realloc(list->entry, room, sizeof *entry);
        if (!entry)
            return STP_ERROR_MEMORY;
        list->entry = entry;
        list->room = room;
    }
    list->entry[list->count++] = (struct deep_entry){ pixel, *layer };
    return STP_OK;
}

void deep_list_release(struct deep_list *list)
{
    mem_free(list->entry);
    *list = (struct deep_list){ 0 };
}

/* first[i + 1] becomes where pixel i begins: putting its layers down moves it to its end. */
static void count_layers(const struct deep_list *lists, unsigned count, size_t pixels,
                         size_t *first)
{
    for (unsigned k = 0; k < count; k++)
        for (size_t i = 0; i < lists[k].count; i++)
            first[lists[k].entry[i].pixel + 1]++;
    size_t sum = 0;
    for (size_t i = 1; i <= pixels; i++) {
        size_t layers = first[i];
        first[i] = sum;
        sum += layers;
    }
}

enum stp_result deep_build(const struct stp_env *env, const struct deep_list *lists, unsigned count,
                           size_t pixels, struct stp_deep **deep)
{
    size_t layers = 0;
    for (unsigned k = 0; k < count; k++)
        layers += lists[k].count;
    struct stp_deep *made = mem_zalloc(1, sizeof *made);
    if (made) {
        made->first = mem_zalloc(pixels + 1, sizeof *made->first);
        made->layer = mem_alloc(layers ? layers : 1, sizeof *made->layer);
    }
    if (!made || !made->first || !made->layer) {
        deep_destroy(&made);
        return log_no_memory(env, layers * sizeof *made->layer + pixels * sizeof *made->first,
                             "a deep picture");
    }
    count_layers(lists, count, pixels, made->first);
    for (unsigned k = 0; k < count; k++)
        for (size_t i = 0; i < lists[k].count; i++)
            made->layer[made->first[lists[k].entry[i].pixel + 1]++] = lists[k].entry[i].layer;
    *deep = made;
    return STP_OK;
}

void deep_destroy(struct stp_deep **deep)
{
    if (!*deep)
        return;
    mem_free((*deep)->first);
    mem_free((*deep)->layer);
    mem_free(*deep);
    *deep = NULL;
}
