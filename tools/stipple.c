/* The command `stipple`: finds the subcommand, parses its options, runs it. */
#include <errno.h>
#include <string.h>

#include "cli.h"

static const struct command commands[] = {
    {
        "info",
        COMMAND_INFO,
        "FILE... [options]",
        "what is in a file, what is wrong with it, what would be done",
        "Reads point files or scenes and says what they hold, what was mended and dropped, and "
        "how they would be rendered. Nothing is written and no device is used.",
        "  stipple info scan.ply\n"
        "  stipple info --json *.ply\n",
        1,
        1 << 20,
        run_info,
    },
    {
        "render",
        COMMAND_RENDER,
        "SCENE -o OUT.exr [options]",
        "a picture of points, a volume or range images, as float EXR",
        "SCENE is a point file (PLY, LAS, PCD, xyz text, OFF, OBJ), a volume (NIfTI, NRRD, "
        "MetaImage, "
        "INRIMAGE, raw), gzip of any, a folder of range images or a scene .json. "
        "Missing normals and radii are estimated, the scene is framed, and a light at the eye is "
        "lit: no option is needed. Lengths are in scene units, angles in degrees.",
        "  stipple render scan.ply -o scan.exr\n"
        "  stipple render scan.ply -o scan.exr --preview scan.png --view -30,15 --samples 4\n"
        "  stipple render scan.ply -o f.%04d.exr --camera path.json --frames 0:99\n",
        1,
        1,
        run_render,
    },
    {
        "plan",
        COMMAND_PLAN,
        "SCENE [options]",
        "what rendering would do, in words, and its bytes; no GPU is touched",
        "Prints the images, buffers and passes that a render with the same options would use, "
        "and why. No GPU is touched.",
        "  stipple plan scan.ply\n"
        "  stipple devices --json > gpu.json && stipple plan scan.ply --limits gpu.json\n",
        1,
        1,
        run_plan,
    },
    {
        "prepare",
        COMMAND_PREPARE,
        "SCENE -o OUT.ply [options]",
        "the prepared splats, as a PLY",
        "Does once what every render would do first: drops what is not finite, estimates normals "
        "and radii, and puts the splats in order. The result renders to the same picture. "
        "With --fit or --fit-count it writes fewer, elliptical splats with linear normal fields, "
        "and says on stderr how many and how near.",
        "  stipple prepare scan.ply -o splats.ply\n"
        "  stipple prepare scan.ply -o few.ply --fit-count 10000\n"
        "  stipple prepare scan.ply -o splats.ply --group --overlap 0.6\n",
        1,
        1,
        run_prepare,
    },
    {
        "compare",
        COMMAND_COMPARE,
        "A.exr B.exr [options]",
        "the error of A against B",
        "Compares linear premultiplied colour, coverage, depth and normals. Bars are stated over "
        "the pixels that either picture covers. In JSON, null stands for infinity (the PSNR of "
        "equal pictures) and for what is not in both.",
        "  stipple compare fast.exr reference.exr\n"
        "  stipple compare fast.exr reference.exr --fail-under-psnr 60\n",
        2,
        2,
        run_compare,
    },
    {
        "report",
        COMMAND_REPORT,
        "SCENE -o DIR [options]",
        "speed against error for every method: CSV, SVG, Markdown",
        "Renders the scene by every method that applies, over its parameters, in turns; measures "
        "each against the float64 reference of the same camera; writes tables, a plot and pictures "
        "of the errors.",
        "  stipple report scan.ply -o report\n"
        "  stipple report scan.ply -o report --quick --size 1024x1024 --cull back\n",
        1,
        1,
        run_report,
    },
    {
        "devices",
        COMMAND_DEVICES,
        "[options]",
        "Vulkan devices, and what each lacks",
        "Lists the Vulkan devices. With --json it prints one profile, of the device that a "
        "render would take, for 'stipple plan --limits'.",
        "  stipple devices\n"
        "  stipple devices --json > profile.json\n",
        0,
        0,
        run_devices,
    },
};
#define COMMANDS (sizeof commands / sizeof *commands)

static const struct command *find_command(const char *name)
{
    for (size_t i = 0; i < COMMANDS; i++)
        if (strcmp(commands[i].name, name) == 0)
            return &commands[i];
    return NULL;
}

static bool is_one_of(const char *text, const char *a, const char *b, const char *c)
{
    return strcmp(text, a) == 0 || strcmp(text, b) == 0 || strcmp(text, c) == 0;
}

/* What was printed must have arrived: a full disk behind a pipe is a failure. */
static int finish(int status)
{
    if (fflush(stdout) == 0 && !ferror(stdout))
        return status;
    fprintf(stderr, "stipple: cannot write to standard output: %s\n", strerror(errno));
    return status == EXIT_DONE ? EXIT_FAILED : status;
}

static int run_command(const struct command *command, int argc, char **argv)
{
    struct settings settings = { .command = command, .word_count = argc, .words = argv };
    switch (options_parse(command, argc, argv, &settings)) {
    case PARSE_RUN:
        settings.context.mask_features = settings.render.mask_features;
        return finish(command->run(&settings));
    case PARSE_SHOWN:
        return finish(EXIT_DONE);
    default:
        return EXIT_COMMAND_LINE;
    }
}

static int no_such_command(const char *word)
{
    char names[256] = "";
    for (size_t i = 0, used = 0; i < COMMANDS && used < sizeof names; i++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i > 0 ? ", " : "",
                                 commands[i].name);
    return wrong_usage(NULL, "no command '%s': %s", word, names);
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        help_all(stderr, commands, COMMANDS);
        return EXIT_COMMAND_LINE;
    }
    const struct command *command = find_command(argv[1]);
    if (command)
        return run_command(command, argc - 1, argv + 1);
    if (is_one_of(argv[1], "--version", "-v", "version")) {
        printf("stipple %s\n", stp_version());
        return finish(EXIT_DONE);
    }
    if (is_one_of(argv[1], "--help", "-h", "help")) {
        command = argc > 2 ? find_command(argv[2]) : NULL;
        if (command)
            help_command(command);
        else
            help_all(stdout, commands, COMMANDS);
        return finish(EXIT_DONE);
    }
    return no_such_command(argv[1]);
}
