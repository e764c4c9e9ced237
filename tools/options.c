/* Parsing a command line by option_table. */
#include <getopt.h>
#include <stdarg.h>
#include <string.h>

#include "cli.h"
#include "machines.h"

#define LONG_BASE 256 /* getopt's value of table entry i is LONG_BASE + i */

int wrong_usage(const struct command *command, const char *format, ...)
{
    va_list args;
    if (!machines_speaks())
        return EXIT_COMMAND_LINE;
    va_start(args, format);
    fputs("stipple: ", stderr);
    vfprintf(stderr, format, args);
    va_end(args);
    fprintf(stderr, "; try 'stipple %s%s--help'\n", command ? command->name : "",
            command ? " " : "");
    return EXIT_COMMAND_LINE;
}

bool option_given(const struct settings *settings, const char *name)
{
    for (unsigned i = 0; i < option_count; i++)
        if (settings->given[i] && strcmp(option_table[i].name, name) == 0)
            return true;
    return false;
}

/* What getopt_long wants to know; both arrays end themselves. */
static void build_getopt(const struct command *command, char *letters, struct option *longs)
{
    *letters++ = ':';
    for (unsigned i = 0; i < option_count; i++) {
        const struct option_spec *spec = &option_table[i];
        if (!(spec->commands & command->bit))
            continue;
        *longs++ = (struct option){ spec->name, spec->argument ? required_argument : no_argument,
                                    NULL, LONG_BASE + (int)i };
        if (spec->letter)
            *letters++ = spec->letter;
        if (spec->letter && spec->argument)
            *letters++ = ':';
    }
    *letters = 0;
    *longs = (struct option){ 0 };
}

static int find_option(const struct command *command, int code)
{
    if (code >= LONG_BASE)
        return code - LONG_BASE;
    for (unsigned i = 0; i < option_count; i++)
        if ((option_table[i].commands & command->bit) && option_table[i].letter == code)
            return (int)i;
    return -1;
}

static const char *allowed_text(const struct option_spec *spec)
{
    return spec->allowed ? spec->allowed : spec->argument;
}

/* `word` is "--xyz" or "--xyz=...": unknown, or the start of more than one option. */
static void report_unknown_long(const struct command *command, const char *word)
{
    char matches[160] = "";
    size_t length = strcspn(word + 2, "="), used = 0;
    for (unsigned i = 0; i < option_count; i++) {
        const struct option_spec *spec = &option_table[i];
        if ((spec->commands & command->bit) && strncmp(spec->name, word + 2, length) == 0 &&
            used < sizeof matches)
            used += (size_t)snprintf(matches + used, sizeof matches - used, "%s--%s",
                                     used ? ", " : "", spec->name);
    }
    if (used)
        wrong_usage(command, "%s could be %s", word, matches);
    else
        wrong_usage(command, "%s has no option %s", command->name, word);
}

static enum parse_outcome report_unknown(const struct command *command, int code, char **argv)
{
    int index = optopt ? find_option(command, optopt) : -1;
    if (code == ':' && index >= 0)
        wrong_usage(command, "--%s wants a value: %s", option_table[index].name,
                    allowed_text(&option_table[index]));
    else if (index >= 0)
        wrong_usage(command, "--%s takes no value", option_table[index].name);
    else if (optopt)
        wrong_usage(command, "%s has no option -%c", command->name, optopt);
    else
        report_unknown_long(command, argv[optind - 1]);
    return PARSE_WRONG;
}

static enum parse_outcome apply_option(const struct command *command, int index,
                                       struct settings *settings)
{
    const struct option_spec *spec = &option_table[index];
    if (!spec->parse) {
        if (strcmp(spec->name, "help") == 0)
            help_command(command);
        else
            printf("stipple %s\n", stp_version());
        return PARSE_SHOWN;
    }
    settings->given[index] = true;
    if (spec->parse(spec, optarg, (char *)settings + spec->offset))
        return PARSE_RUN;
    wrong_usage(command, "--%s '%s': wants %s", spec->name, optarg, allowed_text(spec));
    return PARSE_WRONG;
}

enum parse_outcome options_parse(const struct command *command, int argc, char **argv,
                                 struct settings *settings)
{
    char letters[64];
    struct option longs[MOST_OPTIONS + 1];
    int code;
    build_getopt(command, letters, longs);
    opterr = 0;
    while ((code = getopt_long(argc, argv, letters, longs, NULL)) != -1) {
        int index = code == '?' || code == ':' ? -1 : find_option(command, code);
        enum parse_outcome outcome = index < 0 ? report_unknown(command, code, argv)
                                               : apply_option(command, index, settings);
        if (outcome != PARSE_RUN)
            return outcome;
    }
    settings->files = argv + optind;
    settings->file_count = argc - optind;
    if (settings->file_count >= command->files_least && settings->file_count <= command->files_most)
        return PARSE_RUN;
    if (settings->file_count > command->files_most)
        wrong_usage(command, "%s: '%s' is one file too many", command->name,
                    settings->files[command->files_most]);
    else
        wrong_usage(command, "usage: stipple %s %s", command->name, command->usage);
    return PARSE_WRONG;
}
