/* Files to points. The format is found from the content (probe table), never from the name. */
#ifndef STP_LOAD_LOAD_H
#define STP_LOAD_LOAD_H

#include "base/file.h"
#include "load/cloud.h"

struct load_options {
    enum stp_transfer transfer;
    const char *color_by; /* NULL, "rgb", "normal", "height", "intensity", "class" or a property */
};

/* path is for messages. On failure *cloud is untouched. Fewer points than the header says is an
 * error that names the byte offset. A file of no points is STP_OK with count 0. */
typedef enum stp_result (*reader_fn)(const struct stp_env *env, const char *path,
                                     const struct file_bytes *bytes,
                                     const struct load_options *options, struct cloud *cloud);

#endif
