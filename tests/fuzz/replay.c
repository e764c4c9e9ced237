/* Runs a target on every file of a folder, whole and cut at sixteen places. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"

#define MOST ((size_t)1 << 20)

/* From a block of exactly the size: a sanitizer sees every byte too many. */
static void run(const unsigned char *data, size_t size)
{
    unsigned char *copy = malloc(size ? size : 1);
    fuzz_check(copy != NULL, "memory for the input");
    if (size)
        memcpy(copy, data, size);
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
}

static void replay(const char *path)
{
    unsigned char *data = malloc(MOST);
    FILE *file = fopen(path, "rb");
    fuzz_check(data && file, path);
    size_t size = fread(data, 1, MOST, file);
    fclose(file);
    run(data, size);
    for (size_t i = 0; i < 16; i++)
        run(data, size * i / 16);
    free(data);
}

int main(int argc, char **argv)
{
    char path[4096];
    unsigned count = 0;
    DIR *folder = argc > 1 ? opendir(argv[1]) : NULL;
    fuzz_check(folder != NULL, "a folder of inputs is the argument");
    for (struct dirent *entry; (entry = readdir(folder));) {
        if (entry->d_name[0] == '.')
            continue;
        snprintf(path, sizeof path, "%s/%s", argv[1], entry->d_name);
        replay(path);
        count++;
    }
    closedir(folder);
    printf("%u inputs\n", count);
    fuzz_check(count > 0, "the folder has inputs");
    return 0;
}
