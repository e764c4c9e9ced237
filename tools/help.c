/* --help, laid out for the terminal from the option table. */
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "cli.h"

#define LEFT 26 /* columns of option names */

static int page_width(void)
{
    struct winsize size;
    if (isatty(STDOUT_FILENO) && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col)
        return size.ws_col < 50 ? 50 : size.ws_col > 100 ? 100 : size.ws_col;
    return 80;
}

/* Words of `text` from column `at`, wrapped at the page's width to column `indent`. */
static void print_wrapped(const char *text, int at, int indent)
{
    int width = page_width();
    bool first = true;
    while (*text) {
        int word = (int)strcspn(text, " ");
        if (!first && at + 1 + word > width) {
            printf("\n%*s", indent, "");
            at = indent;
        } else if (!first) {
            putchar(' ');
            at++;
        }
        printf("%.*s", word, text);
        at += word;
        text += word + (text[word] == ' ');
        first = false;
    }
    putchar('\n');
}

static void print_option(const struct option_spec *spec)
{
    char left[128];
    int length = snprintf(left, sizeof left, "  %c%c%s--%s%s%s", spec->letter ? '-' : ' ',
                          spec->letter ? spec->letter : ' ', spec->letter ? ", " : "  ", spec->name,
                          spec->argument ? " " : "", spec->argument ? spec->argument : "");
    printf("%s", left);
    if (length > LEFT - 2) {
        putchar('\n');
        length = 0;
    }
    printf("%*s", LEFT - length, "");
    print_wrapped(spec->help, LEFT, LEFT);
}

/* A heading is due before the first option of its group that this command takes. */
static void print_options(enum command_bit bit)
{
    const char *heading = NULL, *printed = NULL;
    for (unsigned i = 0; i < option_count; i++) {
        const struct option_spec *spec = &option_table[i];
        if (spec->heading)
            heading = spec->heading;
        if (!(spec->commands & bit))
            continue;
        if (!printed || strcmp(heading, printed) != 0)
            printf("\n%s:\n", heading);
        printed = heading;
        print_option(spec);
    }
}

void help_command(const struct command *command)
{
    printf("usage: stipple %s %s\n\n", command->name, command->usage);
    for (const char *at = command->text; *at;) {
        char paragraph[1024];
        int length = (int)strcspn(at, "\n");
        snprintf(paragraph, sizeof paragraph, "%.*s", length, at);
        print_wrapped(paragraph, 0, 0);
        at += length + (at[length] == '\n');
    }
    print_options(command->bit);
    if (command->examples)
        printf("\nExamples:\n%s", command->examples);
}

void help_all(FILE *out, const struct command *commands, unsigned count)
{
    fprintf(out, "usage: stipple COMMAND ...\n\n"
                 "Renders point clouds as smooth, closed, lit surfaces to float OpenEXR.\n\n"
                 "Commands:\n");
    for (unsigned i = 0; i < count; i++)
        fprintf(out, "  %-9s %s\n", commands[i].name, commands[i].summary);
    fprintf(out, "\n'stipple COMMAND --help' lists the options of a command; 'man stipple' has it "
                 "all.\n\n"
                 "Example:\n"
                 "  stipple render scan.ply -o scan.exr --preview scan.png\n");
}
