/* Where results go: checked before anything is computed, written beside their place, renamed. */
#include <errno.h>
#include <libgen.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli.h"

static bool same_file(const char *a, const char *b)
{
    struct stat sa, sb;
    return stat(a, &sa) == 0 && stat(b, &sb) == 0 && sa.st_dev == sb.st_dev &&
           sa.st_ino == sb.st_ino;
}

/* Of a link, the folder of what it names: the new file is written there. */
static bool directory_writable(struct console *console, const char *path)
{
    char *copy = realpath(path, NULL);
    if (!copy)
        copy = strdup(path);
    if (!copy) {
        console_error(console, "out of memory");
        return false;
    }
    const char *folder = dirname(copy);
    struct stat st;
    int error = stat(folder, &st) != 0             ? errno
                : !S_ISDIR(st.st_mode)             ? ENOTDIR
                : access(folder, W_OK | X_OK) != 0 ? errno
                                                   : 0;
    if (error)
        console_error(console, "%s: cannot write in %s: %s", path, folder, strerror(error));
    free(copy);
    return error == 0;
}

bool output_possible(struct console *console, const char *path, const struct settings *settings)
{
    struct stat st;
    for (int i = 0; i < settings->file_count; i++) {
        if (same_file(path, settings->files[i])) {
            console_error(console, "%s: is the input; choose another name to write", path);
            return false;
        }
    }
    if (stat(path, &st) == 0 && !S_ISREG(st.st_mode)) {
        console_error(console, "%s: is there already and is not a regular file", path);
        return false;
    }
    return directory_writable(console, path);
}

bool output_text(struct console *console, const char *path, const char *text)
{
    signals_hold();
    bool done = stp_text_save(&console->env, path, text) == STP_OK;
    signals_release();
    return done;
}

/* After a '%': digits, then 'd'. Returns the length of the conversion, 0 for anything else. */
static size_t conversion_length(const char *at)
{
    size_t digits = strspn(at + 1, "0123456789");
    return at[1 + digits] == 'd' && digits <= 2 ? digits + 2 : 0;
}

bool pattern_valid(const char *pattern)
{
    const char *at = strchr(pattern, '%');
    return at && conversion_length(at) && !strchr(at + 1, '%');
}

char *pattern_expand(const char *pattern, uint32_t frame)
{
    char *path = NULL;
    const char *at = strchr(pattern, '%');
    int width = atoi(at + 1);
    bool zeros = at[1] == '0';
    if (asprintf(&path, zeros ? "%.*s%0*u%s" : "%.*s%*u%s", (int)(at - pattern), pattern, width,
                 frame, at + conversion_length(at)) < 0)
        return NULL;
    return path;
}

static void signal_set(sigset_t *set)
{
    sigemptyset(set);
    sigaddset(set, SIGINT);
    sigaddset(set, SIGTERM);
    sigaddset(set, SIGHUP);
}

void signals_hold(void)
{
    sigset_t set;
    signal_set(&set);
    pthread_sigmask(SIG_BLOCK, &set, NULL);
}

void signals_release(void)
{
    sigset_t set;
    signal_set(&set);
    pthread_sigmask(SIG_UNBLOCK, &set, NULL);
}
