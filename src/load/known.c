/* Formats that people hand over and that are not read here: named, with the way out. */
#include <string.h>

#include "load/readers.h"

struct signature {
    size_t offset;
    const char *bytes;
    size_t length;
    struct known_format format;
};

#define SIGNATURE(offset, text, name, advice)                                                      \
    {                                                                                              \
        offset, text, sizeof(text) - 1,                                                            \
        {                                                                                          \
            name, advice                                                                           \
        }                                                                                          \
    }

static const char to_ply[] = "convert it to PLY";
static const char points_only[] = "an image holds no points; give a point file";
static const char unpack[] = "unpack it first (gzip is the one packing that is read)";
static const char sample[] = "sample its surface to points, as PLY, with normals";
static const char volume[] = "a volume is not a point file";

static const struct signature signatures[] = {
    SIGNATURE(0, "ASTM-E57", "E57", to_ply),
    SIGNATURE(0, "DRACO", "Draco", to_ply),
    SIGNATURE(0, "glTF", "binary glTF", sample),
    SIGNATURE(0, "Kaydara FBX", "FBX", sample),
    SIGNATURE(0, "solid ", "STL", sample),
    SIGNATURE(0, "#VRML", "VRML", sample),
    SIGNATURE(0, "<?xml", "XML", to_ply),
    SIGNATURE(0, "# vtk DataFile", "VTK", to_ply),
    SIGNATURE(0, "#INRIMAGE", "INRIMAGE", volume),
    SIGNATURE(344, "n+1\0", "NIfTI", volume),
    SIGNATURE(344, "ni1\0", "NIfTI", volume),
    SIGNATURE(4, "n+2\0\r\n\032\n", "NIfTI-2", "write it as NIfTI-1"),
    SIGNATURE(0, "NRRD000", "NRRD", volume),
    SIGNATURE(0, "\x89HDF\r\n", "HDF5", to_ply),
    SIGNATURE(0, "\x93NUMPY", "NumPy", to_ply),
    SIGNATURE(0, "\x89PNG", "PNG", points_only),
    SIGNATURE(0, "\xff\xd8\xff", "JPEG", points_only),
    SIGNATURE(0, "II*\0", "TIFF", points_only),
    SIGNATURE(0, "MM\0*", "TIFF", points_only),
    SIGNATURE(0, "\x76\x2f\x31\x01", "OpenEXR", points_only),
    SIGNATURE(0, "P5\n", "PGM", points_only),
    SIGNATURE(0, "P6\n", "PPM", points_only),
    SIGNATURE(0, "PK\3\4", "zip", unpack),
    SIGNATURE(0, "\x28\xb5\x2f\xfd", "zstd", unpack),
    SIGNATURE(0,
              "\xfd"
              "7zXZ",
              "xz", unpack),
    SIGNATURE(0, "BZh", "bzip2", unpack),
    SIGNATURE(0, "7z\xbc\xaf", "7z", unpack),
    SIGNATURE(0, "\x1f\x8b", "gzip that is cut short, or within gzip,",
              "get the whole file, or unpack it first"),
    SIGNATURE(0, "{", "JSON (glTF?)", "give a point file, or a scene .json of stipple"),
};

/* Eighty bytes of anything, a count of triangles, and exactly that many records of 50 bytes. */
static bool is_binary_stl(const struct file_bytes *bytes)
{
    if (bytes->size < 84)
        return false;
    const unsigned char *p = bytes->data + 80;
    uint32_t count = p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
    return bytes->size == 84 + 50 * (uint64_t)count;
}

bool known_format_find(const struct file_bytes *bytes, struct known_format *known)
{
    for (size_t i = 0; i < sizeof signatures / sizeof *signatures; i++) {
        const struct signature *s = &signatures[i];
        if (bytes->size >= s->offset + s->length &&
            memcmp(bytes->data + s->offset, s->bytes, s->length) == 0) {
            *known = s->format;
            return true;
        }
    }
    if (is_binary_stl(bytes)) {
        *known = (struct known_format){ "binary STL", sample };
        return true;
    }
    return false;
}
