/* Log lines and the progress bar. Both go to stderr; a line erases the bar first. */
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "cli.h"

#define ERASE "\r\033[K"

/* A handler can see nothing else. */
static volatile sig_atomic_t bar_is_drawn;

double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static void erase_bar(void)
{
    if (bar_is_drawn)
        fputs(ERASE, stderr);
    bar_is_drawn = 0;
}

static void print_line(struct console *console, enum stp_log_level level, const char *line)
{
    if (level == STP_LOG_WARNING && console->quiet)
        return;
    if (level == STP_LOG_INFO && !console->verbose)
        return;
    if (console->holds) {
        if (level == STP_LOG_ERROR && !console->held[0])
            snprintf(console->held, sizeof console->held, "%s", line);
        return;
    }
    flockfile(stderr); /* the context may be made on a second thread */
    erase_bar();
    fprintf(stderr, "stipple: %s%s\n", level == STP_LOG_WARNING ? "warning: " : "", line);
    funlockfile(stderr);
}

void console_release(struct console *console, unsigned rank)
{
    char line[sizeof console->held + 32];
    if (!console->held[0])
        return;
    snprintf(line, sizeof line, "process %u: %s", rank, console->held);
    console->held[0] = 0;
    console->holds = false;
    print_line(console, STP_LOG_ERROR, line);
}

static void on_log(void *user, enum stp_log_level level, const char *line)
{
    print_line(user, level, line);
}

static void print_format(struct console *console, enum stp_log_level level, const char *format,
                         va_list args)
{
    char line[1024];
    vsnprintf(line, sizeof line, format, args);
    print_line(console, level, line);
}

void console_error(struct console *console, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    print_format(console, STP_LOG_ERROR, format, args);
    va_end(args);
}

void console_warning(struct console *console, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    print_format(console, STP_LOG_WARNING, format, args);
    va_end(args);
}

void console_info(struct console *console, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    print_format(console, STP_LOG_INFO, format, args);
    va_end(args);
}

static int terminal_width(void)
{
    struct winsize size;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col)
        return size.ws_col;
    return 80;
}

/* "prepare  [========>          ]  42 %", never wider than the terminal. */
static void draw_bar(const char *stage, double fraction)
{
    char cells[101];
    int width = terminal_width() - 1, percent = (int)(fraction * 100 + 0.5);
    int room = width - 12 - 2 - 6; /* the stage's name, the brackets, the percentage */
    room = room > 60 ? 60 : room;
    flockfile(stderr);
    if (room >= 10) {
        int full = (int)(fraction * room);
        memset(cells, ' ', (size_t)room);
        memset(cells, '=', (size_t)full);
        if (full < room)
            cells[full] = '>';
        fprintf(stderr, ERASE "%-12.12s[%.*s] %3d %%", stage, room, cells, percent);
    } else if (width >= 17) {
        fprintf(stderr, ERASE "%-10.10s %3d %%", stage, percent);
    } else {
        fprintf(stderr, ERASE "%3d %%", percent);
    }
    fflush(stderr);
    bar_is_drawn = 1;
    funlockfile(stderr);
}

/* Nothing in the first second, then at most ten times a second. */
static void on_progress(void *user, const char *stage, double fraction)
{
    struct console *console = user;
    double now = seconds_now();
    if (now - console->started < 1 || now - console->drawn < 0.1)
        return;
    console->drawn = now;
    draw_bar(stage, fraction < 0 ? 0 : fraction > 1 ? 1 : fraction);
}

static void on_signal(int number)
{
    if (bar_is_drawn && write(STDERR_FILENO, ERASE, strlen(ERASE)) < 0)
        bar_is_drawn = 0;
    signal(number, SIG_DFL);
    raise(number);
}

void console_open(struct console *console, const struct settings *settings)
{
    const char *terminal = getenv("TERM");
    bool dumb = !terminal || strcmp(terminal, "dumb") == 0;
    *console = (struct console){
        .quiet = settings->quiet,
        .verbose = settings->verbose,
        .bar = !settings->quiet && !dumb && isatty(STDERR_FILENO),
        .started = seconds_now(),
    };
    console->env = (struct stp_env){
        .threads = settings->threads,
        .log = on_log,
        .progress = console->bar ? on_progress : NULL,
        .user = console,
    };
    if (console->bar) {
        signal(SIGINT, on_signal);
        signal(SIGTERM, on_signal);
    }
}

void console_close(struct console *console)
{
    (void)console;
    erase_bar();
}
