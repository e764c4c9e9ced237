/* Prepared splats as a PLY that any reader understands and that reads back bit for bit. Properties,
 * little-endian: double x y z; float nx ny nz (0: unknown); float radius; float red green blue
 * (linear) where there are colours; float opacity where something is transparent; of ellipses float
 * tangent_x .. field_3, and where some have clip lines float clip_0_a .. clip_1_c, uchar clip_count
 * clip_reflex; uint input_index; ushort object where there are several; uchar group where the scene
 * is grouped. */
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/log.h"
#include "base/memory.h"
#include "prepare/prepare.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the records below are copied as they lie in memory"
#endif

#define BATCH       4096
#define RECORD_SIZE (24 + 12 + 4 + 12 + 4 + 62 + 4 + 2 + 1)

static void write_header(FILE *file, const struct stp_scene *scene)
{
    const struct splats *s = &scene->splats;
    fprintf(file, "ply\nformat binary_little_endian 1.0\ncomment stipple prepared 1\n");
    for (unsigned i = 0; i < scene->object_count; i++) {
        char epsilon[JSON_NUMBER_SIZE]; /* read back bit for bit, whatever the locale */
        fprintf(file, "comment stipple object %u epsilon %s%s\n", i,
                json_number_text(scene->objects[i].epsilon, epsilon),
                scene->objects[i].estimated ? " normals estimated" : "");
    }
    fprintf(file,
            "element vertex %zu\nproperty double x\nproperty double y\nproperty double z\n"
            "property float nx\nproperty float ny\nproperty float nz\nproperty float radius\n",
            s->count);
    if (s->color)
        fprintf(file, "property float red\nproperty float green\nproperty float blue\n");
    if (s->opacity)
        fprintf(file, "property float opacity\n");
    if (s->phong)
        fprintf(file, "property float tangent_x\nproperty float tangent_y\n"
                      "property float tangent_z\nproperty float radius_u\nproperty float radius_v\n"
                      "property float field_0\nproperty float field_1\nproperty float field_2\n"
                      "property float field_3\n");
    if (scene->facts.clip_lines)
        fprintf(file, "property float clip_0_a\nproperty float clip_0_b\nproperty float clip_0_c\n"
                      "property float clip_1_a\nproperty float clip_1_b\nproperty float clip_1_c\n"
                      "property uchar clip_count\nproperty uchar clip_reflex\n");
    fprintf(file, "property uint input_index\n");
    if (s->object)
        fprintf(file, "property ushort object\n");
    if (s->group)
        fprintf(file, "property uchar group\n");
    fprintf(file, "end_header\n");
}

/* Appends element i of an array that may be missing. */
static unsigned char *put(unsigned char *at, const void *array, size_t i, size_t size)
{
    if (!array)
        return at;
    memcpy(at, (const char *)array + i * size, size);
    return at + size;
}

static unsigned char *put_phong(unsigned char *at, const struct stp_phong_splat *p, bool clips)
{
    at = put(at, p->u, 0, sizeof p->u);
    at = put(at, p->radius, 0, sizeof p->radius);
    at = put(at, p->field, 0, sizeof p->field);
    if (!clips)
        return at;
    at = put(at, p->clip, 0, sizeof p->clip);
    at = put(at, &p->clips, 0, 1);
    return put(at, &p->reflex, 0, 1);
}

static unsigned char *put_splat(unsigned char *at, const struct splats *s, size_t i, bool clips)
{
    at = put(at, s->position, i, sizeof *s->position);
    at = put(at, s->normal, i, sizeof *s->normal);
    at = put(at, s->radius, i, sizeof *s->radius);
    at = put(at, s->color, i, sizeof *s->color);
    at = put(at, s->opacity, i, sizeof *s->opacity);
    if (s->phong)
        at = put_phong(at, &s->phong[i], clips);
    at = put(at, s->input, i, sizeof *s->input);
    at = put(at, s->object, i, sizeof *s->object);
    return put(at, s->group, i, sizeof *s->group);
}

/* A short write is left to file_commit: it sees ferror. */
static void write_splats(FILE *file, const struct stp_scene *scene, unsigned char *buffer)
{
    const struct splats *s = &scene->splats;
    bool clips = scene->facts.clip_lines > 0;
    for (size_t begin = 0; begin < s->count && !ferror(file); begin += BATCH) {
        size_t end = begin + BATCH < s->count ? begin + BATCH : s->count;
        unsigned char *at = buffer;
        for (size_t i = begin; i < end; i++)
            at = put_splat(at, s, i, clips);
        fwrite(buffer, 1, (size_t)(at - buffer), file);
    }
}

enum stp_result stp_scene_save(const struct stp_env *env, const struct stp_scene *scene,
                               const char *path)
{
    struct file_output out;
    if (scene->stream)
        return scene_check_whole(env, scene, "saving splats");
    if (!scene->prepared || scene->share.count)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "%s: the scene must be prepared, and whole, to be saved", path);
    if (scene->volume)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: a volume has no splats to be saved", path);
    unsigned char *buffer = mem_alloc(BATCH, RECORD_SIZE);
    if (!buffer)
        return log_no_memory(env, BATCH * RECORD_SIZE, path);
    enum stp_result result = file_begin(env, path, &out);
    if (result == STP_OK) {
        write_header(out.stream, scene);
        write_splats(out.stream, scene, buffer);
        result = file_commit(env, &out);
    }
    mem_free(buffer);
    return result;
}
