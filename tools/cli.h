/* What the subcommands of `stipple` share. The command is a client of the public headers only. */
#ifndef STIPPLE_TOOLS_CLI_H
#define STIPPLE_TOOLS_CLI_H

#include <stipple/stipple.h>

#include <pthread.h>
#include <stdio.h>

/* Exit statuses; the man page lists them. */
enum {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,       /* rendering, comparing or writing failed */
    EXIT_COMMAND_LINE = 2, /* nothing was read or written */
    EXIT_BAD_INPUT = 3,    /* a file could not be read, is damaged, or holds nothing */
};

/* Or-ed in the option table: which commands take an option. */
enum command_bit {
    COMMAND_INFO = 1,
    COMMAND_RENDER = 2,
    COMMAND_PLAN = 4,
    COMMAND_PREPARE = 8,
    COMMAND_COMPARE = 16,
    COMMAND_DEVICES = 32,
    COMMAND_REPORT = 64,
};

struct settings;

struct command {
    const char *name;
    enum command_bit bit;
    const char *usage;   /* after "stipple NAME " */
    const char *summary; /* one line, for `stipple --help` */
    const char *text;    /* paragraphs, for `stipple NAME --help` */
    const char *examples;
    int files_least, files_most;
    int (*run)(struct settings *settings);
};

#define MOST_OPTIONS 128

/* What several processes share out. */
enum split { SPLIT_POINTS = 0, SPLIT_FRAMES };

/* Everything an option can set. Zero is the default throughout, as in the library's structs. */
struct settings {
    const struct command *command;
    bool given[MOST_OPTIONS]; /* option i of the table was on the command line */
    char **files;
    int file_count;
    int word_count; /* the command line, from the command's name on, as getopt left it */
    char **words;

    struct stp_load_params load;
    struct stp_prepare_params prepare;
    struct stp_group_params group;
    struct stp_fit_params fit;
    struct stp_frame_params frame;
    struct stp_render_params render;
    struct stp_context_params context;
    struct stp_exr_params exr;
    struct stp_compare_params compare;
    struct stp_optics optics;
    struct stp_environment_params around;

    double clip_box[6];
    float background[4];
    const char *environment;
    const char *output, *deep, *preview, *stats, *camera, *write_camera, *limits;
    uint32_t first_frame, last_frame;
    double exposure, least_psnr;
    unsigned repeat, threads, rounds, fit_count;
    unsigned split; /* enum split */
    enum stp_toggle stream;
    bool half, quick, json, quiet, verbose, with_groups, calibrate;
};

/* option_table.c: the one table; options.c: its parser. */

struct option_spec;
/* Writes `text` to `target`; false: not allowed, and nothing is written. */
typedef bool (*value_fn)(const struct option_spec *spec, const char *text, void *target);

struct value_name {
    const char *name;
    unsigned bit;
};

struct option_spec {
    const char *heading; /* of the group in --help that starts here; else NULL */
    unsigned commands;   /* enum command_bit, or-ed */
    const char *name;
    char letter;          /* 0: none */
    const char *argument; /* NULL: a flag. A choice lists its values: "auto|on|off" */
    const char *help;     /* ends with the default */
    value_fn parse;
    size_t offset;       /* of the target in struct settings */
    const char *allowed; /* for the line about a wrong value; NULL: `argument` says it */
    double low, high;    /* of numbers, both inclusive */
    const struct value_name *names;
};

extern const struct option_spec option_table[];
extern const unsigned option_count;

enum parse_outcome { PARSE_RUN, PARSE_SHOWN, PARSE_WRONG };
/* argv[0] is the command's name. PARSE_SHOWN: --help or --version was answered on stdout. */
enum parse_outcome options_parse(const struct command *command, int argc, char **argv,
                                 struct settings *settings);
bool option_given(const struct settings *settings, const char *name);

/* One line on stderr that ends with where to read more. Returns EXIT_COMMAND_LINE. */
int wrong_usage(const struct command *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* help.c */

void help_command(const struct command *command);
void help_all(FILE *out, const struct command *commands, unsigned count);

/* values.c: one parser for each kind of value. */

bool value_flag(const struct option_spec *spec, const char *text, void *target);     /* bool */
bool value_text(const struct option_spec *spec, const char *text, void *target);     /* char * */
bool value_path(const struct option_spec *spec, const char *text, void *target);     /* char * */
bool value_real(const struct option_spec *spec, const char *text, void *target);     /* double */
bool value_degrees(const struct option_spec *spec, const char *text, void *target);  /* double */
bool value_count(const struct option_spec *spec, const char *text, void *target);    /* unsigned */
bool value_bytes(const struct option_spec *spec, const char *text, void *target);    /* uint64_t */
bool value_choice(const struct option_spec *spec, const char *text, void *target);   /* enum */
bool value_names(const struct option_spec *spec, const char *text, void *target);    /* unsigned */
bool value_features(const struct option_spec *spec, const char *text, void *target); /* unsigned */
/* These write to the settings as a whole: target is struct settings. */
bool value_size(const struct option_spec *spec, const char *text, void *target);
bool value_view(const struct option_spec *spec, const char *text, void *target);
bool value_clip_box(const struct option_spec *spec, const char *text, void *target);
bool value_volume_dims(const struct option_spec *spec, const char *text, void *target);
bool value_volume_spacing(const struct option_spec *spec, const char *text, void *target);
bool value_or_none(const struct option_spec *spec, const char *text, void *target); /* double */
bool value_axis_h(const struct option_spec *spec, const char *text, void *target);  /* double */
bool value_background(const struct option_spec *spec, const char *text, void *target);
bool value_frames(const struct option_spec *spec, const char *text, void *target);
bool value_optics(const struct option_spec *spec, const char *text, void *target);    /* float[] */
bool value_intensity(const struct option_spec *spec, const char *text, void *target); /* float */
bool value_opacity(const struct option_spec *spec, const char *text, void *target);
bool value_min_splat(const struct option_spec *spec, const char *text, void *target);

extern const struct value_name aov_names[], relax_names[];

/* console.c: log lines and the progress bar on stderr. */

struct console {
    struct stp_env env; /* env.user is this console */
    bool quiet, verbose, bar;
    double started, drawn; /* seconds */
    bool holds;            /* one of several processes: the first error is kept, not printed */
    char held[1024];
    bool told_unused; /* of options that have no effect, once whatever the frames */
};
/* The console must not move while its env is in use. */
void console_open(struct console *console, const struct settings *settings);
void console_close(struct console *console);
/* Prints the line that is held, with the process's rank. */
void console_release(struct console *console, unsigned rank);
/* One line, "stipple: ...", in the same manner as the library's. */
void console_error(struct console *console, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void console_warning(struct console *console, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* With --verbose only. */
void console_info(struct console *console, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
double seconds_now(void);

/* output.c */

/* Before anything is computed: can `path` be written, and is it none of the inputs? Logs. */
bool output_possible(struct console *console, const char *path, const struct settings *settings);
/* Writes beside `path` and renames. */
bool output_text(struct console *console, const char *path, const char *text);
/* True when `pattern` has exactly one %d (or %04d and the like). */
bool pattern_valid(const char *pattern);
/* The path of a frame, to be freed; NULL: out of memory. */
char *pattern_expand(const char *pattern, uint32_t frame);

/* Signals that would end the process wait until the file being written is whole. */
void signals_hold(void);
void signals_release(void);

/* stages.c: from the settings to library objects. */

struct run_times {
    double load, prepare, write; /* milliseconds; prepare includes grouping */
};

/* The exit status for a failure while reading inputs. */
int exit_of_input(enum stp_result result);
/* times may be NULL. */
int load_and_prepare(struct console *console, const struct settings *settings, const char *path,
                     struct stp_scene **scene, struct run_times *times);
/* Whether float32 has lost where the points lie: normals are off by degrees where its steps are a
 * sixteenth of a radius and more. */
bool facts_coarse(const struct stp_facts *facts);
/* False, and says so, where --camera and the options of framing contradict each other. */
bool camera_usage_right(const struct settings *settings);
/* The camera of frame `frame`: of --camera, of the scene, or framed. *count (may be NULL) gets
 * the length of a camera path, 1 without. */
int find_camera(struct console *console, const struct settings *settings,
                const struct stp_scene *scene, uint32_t frame, struct stp_camera *camera,
                uint32_t *count);
/* Decides what the settings leave to auto, and groups the scene where that wants it. choice->params
 * is what to plan with. */
int choose_way(struct console *console, const struct settings *settings, struct stp_scene *scene,
               const struct stp_camera *camera, const struct stp_limits *limits,
               struct stp_choice *choice);

/* context.c: making a context takes long enough to be worth a thread beside loading. */

struct context_job {
    pthread_t thread;
    bool threaded;
    struct console *console;
    struct stp_context_params params;
    struct stp_context *context;
    enum stp_result result;
    char error[1024];
};
/* The job must not move until it is closed. */
void context_start(struct context_job *job, struct console *console,
                   const struct stp_context_params *params);
/* Waits; logs a failure. */
int context_finish(struct context_job *job, const struct stp_limits **limits);
/* Only who asks for a bound waits for measurements. */
int context_calibrate(struct context_job *job, const struct settings *settings,
                      const struct stp_facts *facts);
/* Safe for a job that was never started. */
void context_close(struct context_job *job);

/* json_out.c */

struct cJSON;
/* JSON being built: what there was no memory for is left out and remembered, so that only the end
 * has to ask. Into a parent of NULL nothing is put. */
struct json_out {
    bool failed;
};
struct cJSON *json_begin(struct json_out *out, struct cJSON *root); /* notes a NULL */
/* key NULL: the parent is an array. */
struct cJSON *json_object(struct json_out *out, struct cJSON *parent, const char *key);
struct cJSON *json_array(struct json_out *out, struct cJSON *parent, const char *key);
/* What is not finite becomes null. */
void json_number(struct json_out *out, struct cJSON *parent, const char *key, double value);
void json_numbers(struct json_out *out, struct cJSON *parent, const char *key, const double *values,
                  int count);
void json_text(struct json_out *out, struct cJSON *parent, const char *key, const char *value);
void json_bool(struct json_out *out, struct cJSON *parent, const char *key, bool value);
/* To stdout; says so, and EXIT_FAILED, where something is missing. */
int json_print(struct console *console, struct json_out *out, const struct cJSON *root);

/* pictures.c */

/* The flat and the deep file and the preview of frame `index`, as far as they are wanted. */
int write_pictures(struct console *console, const struct settings *settings,
                   const struct stp_plan *plan, struct stp_image *image, uint32_t index);

/* stats.c */

/* One frame's object, with the keys that the man page lists, at the end of the list. */
void stats_add(struct json_out *out, struct cJSON *list, const struct stp_limits *limits,
               const struct stp_facts *facts, const struct stp_plan *plan,
               const struct stp_render_stats *render, const struct run_times *times,
               const struct stp_image *image);

/* The commands. */

int run_info(struct settings *settings);
int run_render(struct settings *settings);
int run_plan(struct settings *settings);
int run_prepare(struct settings *settings);
int run_compare(struct settings *settings);
int run_devices(struct settings *settings);
int run_report(struct settings *settings);

#endif
