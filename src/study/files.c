#include "study/study.h"

#include <errno.h>
#include <locale.h>
#include <string.h>

#include "base/file.h"
#include "base/log.h"
#include "base/memory.h"

/* folder/name; to be freed with mem_free. NULL: out of memory, logged. */
static char *path_in(const struct stp_env *env, const char *folder, const char *name)
{
    size_t length = strlen(folder) + strlen(name) + 2;
    char *path = mem_alloc(length, 1);
    if (!path)
        log_no_memory(env, length, "a file's name");
    else
        snprintf(path, length, "%s/%s", folder, name);
    return path;
}

typedef void (*writer_fn)(FILE *out, const struct report *report);

static enum stp_result write_text(const struct study *study, const char *folder, const char *name,
                                  writer_fn writer)
{
    struct file_output out = { 0 };
    char *path = path_in(study->env, folder, name);
    if (!path)
        return STP_ERROR_MEMORY;
    enum stp_result result = file_begin(study->env, path, &out);
    if (result == STP_OK) {
        writer(out.stream, &study->report);
        result = file_commit(study->env, &out);
    }
    mem_free(path);
    return result;
}

/* Numbers have points whatever the caller's locale says. */
static enum stp_result write_texts(const struct study *study, const char *folder)
{
    static const struct {
        const char *name;
        writer_fn writer;
    } files[] = { { "report.csv", report_csv },
                  { "report.svg", report_svg },
                  { "report.md", report_markdown },
                  { "auto.csv", report_picks_csv },
                  { "samples.csv", report_samples_csv } };
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0)
        return log_error(study->env, STP_ERROR_MEMORY, "cannot make a locale: %s", strerror(errno));
    locale_t old = uselocale(plain);
    enum stp_result result = STP_OK;
    for (unsigned i = 0; result == STP_OK && i < sizeof files / sizeof *files; i++)
        result = write_text(study, folder, files[i].name, files[i].writer);
    uselocale(old);
    freelocale(plain);
    return result;
}

static enum stp_result write_heat(const struct study *study, const char *folder,
                                  const struct heat *heat, const char *name)
{
    struct stp_image *picture = NULL;
    char *path = path_in(study->env, folder, name);
    if (!path)
        return STP_ERROR_MEMORY;
    enum stp_result result = heat_picture(study->env, heat, &picture);
    if (result == STP_OK)
        result = stp_image_write_png(study->env, picture, path, 0);
    stp_image_destroy(&picture);
    mem_free(path);
    return result;
}

/* Those of an earlier report whose front was longer. */
static enum stp_result remove_heats(const struct study *study, const char *folder, unsigned first)
{
    for (unsigned i = first; i < STUDY_MAX_CONFIGS + REPORT_MAX_PICKS; i++) {
        char name[32];
        snprintf(name, sizeof name, "error_%u.png", i + 1);
        char *path = path_in(study->env, folder, name);
        if (!path)
            return STP_ERROR_MEMORY;
        remove(path);
        mem_free(path);
    }
    return STP_OK;
}

enum stp_result study_write(struct study *study, const char *folder)
{
    const struct report_row *front[STUDY_MAX_CONFIGS + REPORT_MAX_PICKS];
    unsigned count = report_front(&study->report, front);
    enum stp_result result = STP_OK;
    for (unsigned i = 0; result == STP_OK && i < count; i++) {
        size_t index = (size_t)(front[i] - study->report.row);
        char *name = study->report.row[index].picture;
        snprintf(name, sizeof study->report.row[index].picture, "error_%u.png", i + 1);
        result = write_heat(study, folder, &study->frame[index].heat, name);
    }
    if (result == STP_OK)
        result = remove_heats(study, folder, count);
    return result == STP_OK ? write_texts(study, folder) : result;
}
