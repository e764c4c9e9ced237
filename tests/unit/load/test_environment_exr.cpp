// OpenEXR maps written here by its C++ library in every way that a map comes: the lossy
// compressions that the C core lacks, tiles, halves, grey, windows off the origin; and what is
// refused.
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <unistd.h>
#include <vector>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfTiledOutputFile.h>

extern "C" {
#include <cmocka.h>
#include "base/memory.h"
#include "load/environment.h"
#include "load/range.h"
}

static const int W = 64, H = 32;

static float value(int x, int y, int k)
{
    return 0.5f + 0.4f * std::sin(0.2f * static_cast<float>(x) + static_cast<float>(k)) *
                      std::cos(0.3f * static_cast<float>(y));
}

struct Log {
    unsigned errors = 0, warnings = 0;
    std::string last;
};

static void keep(void *user, enum stp_log_level level, const char *line)
{
    Log *log = static_cast<Log *>(user);
    (level == STP_LOG_ERROR ? log->errors : log->warnings)++;
    log->last = line;
}

class Scratch
{
  public:
    Scratch()
    {
        char name[] = "/tmp/stipple-test-XXXXXX";
        int file = mkstemp(name);
        assert_true(file >= 0);
        close(file);
        path = name;
    }
    ~Scratch()
    {
        unlink(path.c_str());
    }
    std::string path;
};

static enum stp_result read_map(const std::string &path, struct environment_map *map, Log *log)
{
    struct stp_env env = {};
    env.log = keep;
    env.user = log;
    enum stp_result result = environment_read(&env, path.c_str(), map);
    assert_int_equal(log->errors, result != STP_OK);
    return result;
}

static Imf::FrameBuffer slices(std::vector<float> &data, const Imath::Box2i &window,
                               const char *const *names)
{
    Imf::FrameBuffer frame;
    data.resize(static_cast<size_t>(W) * H * 3);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            for (int k = 0; k < 3; k++)
                data[static_cast<size_t>((y * W + x) * 3 + k)] = value(x, y, k);
    for (int k = 0; names[k]; k++)
        frame.insert(names[k], Imf::Slice::Make(Imf::FLOAT, &data[static_cast<size_t>(k)], window,
                                                12, 12 * W));
    return frame;
}

static const char *const rgb[] = { "R", "G", "B", nullptr }, *const grey[] = { "Y", nullptr };

static Imf::Header make_header(const Imath::Box2i &window, Imf::Compression compression,
                               const char *const *names)
{
    Imf::Header header(Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(W + 9, H + 9)), window);
    header.compression() = compression;
    for (int k = 0; names[k]; k++)
        header.channels().insert(names[k], Imf::Channel(Imf::FLOAT));
    return header;
}

static void write_lines(const std::string &path, const Imath::Box2i &window,
                        Imf::Compression compression, const char *const *names)
{
    std::vector<float> data;
    Imf::OutputFile file(path.c_str(), make_header(window, compression, names));
    file.setFrameBuffer(slices(data, window, names));
    file.writePixels(H);
}

static void write_tiles(const std::string &path, const Imath::Box2i &window,
                        Imf::Compression compression)
{
    std::vector<float> data;
    Imf::Header header = make_header(window, compression, rgb);
    header.setTileDescription(Imf::TileDescription(24, 16, Imf::ONE_LEVEL));
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(slices(data, window, rgb));
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
}

static const Imath::Box2i at_origin(Imath::V2i(0, 0), Imath::V2i(W - 1, H - 1));
static const Imath::Box2i elsewhere(Imath::V2i(-7, 5), Imath::V2i(W - 8, H + 4));

static void expect_map(const std::string &path, double tolerance, bool is_grey)
{
    struct environment_map map = {};
    Log log;
    assert_int_equal(read_map(path, &map, &log), STP_OK);
    assert_true(map.width == W && map.height == H && log.warnings == 0);
    double worst = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            for (int k = 0; k < 3; k++)
                worst =
                    std::fmax(worst, std::fabs(static_cast<double>(map.texel[y * W + x][k]) -
                                               static_cast<double>(value(x, y, is_grey ? 0 : k))));
    environment_map_release(&map);
    if (!(worst <= tolerance))
        fail_msg("%s: off by %g", path.c_str(), worst);
}

static void test_compressions(void **)
{
    for (int c = Imf::NO_COMPRESSION; c < Imf::NUM_COMPRESSION_METHODS; c++) {
        Scratch scratch;
        const Imf::Compression compression = static_cast<Imf::Compression>(c);
        const bool lossy =
            c == Imf::PXR24_COMPRESSION || c == Imf::DWAA_COMPRESSION || c == Imf::DWAB_COMPRESSION;
        for (int tiled = 0; tiled < 2; tiled++)
            for (const Imath::Box2i &window : { at_origin, elsewhere }) {
                if (tiled)
                    write_tiles(scratch.path, window, compression);
                else
                    write_lines(scratch.path, window, compression, rgb);
                expect_map(scratch.path, lossy ? 0.02 : 0, false);
            }
    }
}

static void test_grey(void **)
{
    Scratch scratch;
    write_lines(scratch.path, elsewhere, Imf::ZIP_COMPRESSION, grey);
    expect_map(scratch.path, 0, true);
}

static void write_parts(const std::string &path, const char *const *first,
                        const char *const *second)
{
    const char *const *channels[2] = { first, second };
    std::vector<Imf::Header> headers;
    for (int i = 0; i < 2; i++) {
        headers.push_back(make_header(at_origin, Imf::ZIP_COMPRESSION, channels[i]));
        headers[static_cast<size_t>(i)].setName(i ? "second" : "first");
        headers[static_cast<size_t>(i)].setType(Imf::SCANLINEIMAGE);
    }
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), 2);
    for (int i = 0; i < 2; i++) {
        std::vector<float> data;
        Imf::OutputPart part(file, i);
        part.setFrameBuffer(slices(data, at_origin, channels[i]));
        part.writePixels(H);
    }
}

/* Of two parts the first is read, and a line says so; what only the second has is missing. */
static void test_parts(void **)
{
    static const char *const words = "of its 2 parts only the first is read: \"first\"";
    Scratch scratch;
    struct environment_map map = {};
    struct range_image image = {};
    Log log;
    write_parts(scratch.path, rgb, grey);
    assert_int_equal(read_map(scratch.path, &map, &log), STP_OK);
    assert_true(log.warnings == 1 && log.last.find(words) != std::string::npos);
    assert_true(map.texel[1][2] == value(1, 0, 2));
    environment_map_release(&map);
    struct stp_env env = {};
    env.log = keep;
    env.user = &log;
    assert_int_equal(range_image_read(&env, scratch.path.c_str(), RANGE_COLOR, &image), STP_OK);
    assert_true(log.warnings == 2 && log.last.find(words) != std::string::npos);
    range_image_release(&image);
    assert_int_equal(range_image_read(&env, scratch.path.c_str(), RANGE_DEPTH, &image),
                     STP_ERROR_FORMAT);
    assert_true(log.warnings == 3 && log.last.find("no channel Z") != std::string::npos);
}

static void expect_refused(const std::string &path, const char *words)
{
    struct environment_map map = {};
    Log log;
    assert_int_equal(read_map(path, &map, &log), STP_ERROR_FORMAT);
    assert_null(map.texel);
    if (log.last.find(words) == std::string::npos)
        fail_msg("'%s' lacks '%s'", log.last.c_str(), words);
}

static void test_refused(void **)
{
    static const char *const half[] = { "R", "G", nullptr };
    Scratch scratch;
    write_lines(scratch.path, at_origin, Imf::ZIP_COMPRESSION, half);
    expect_refused(scratch.path, "no channels R G B");
    {
        std::vector<float> data;
        Imf::Header header = make_header(at_origin, Imf::ZIP_COMPRESSION, rgb);
        Imf::addEnvmap(header, Imf::ENVMAP_CUBE);
        Imf::OutputFile file(scratch.path.c_str(), header);
        file.setFrameBuffer(slices(data, at_origin, rgb));
        file.writePixels(H);
    }
    expect_refused(scratch.path, "cube map");
    {
        Imf::Header header = make_header(at_origin, Imf::ZIPS_COMPRESSION, rgb);
        header.setType(Imf::DEEPSCANLINE);
        Imf::DeepScanLineOutputFile file(scratch.path.c_str(), header);
    }
    expect_refused(scratch.path, "deep EXR");
}

/* An attribute that claims more bytes than the file has is named; the library would take the room.
 */
static void test_huge_attribute(void **)
{
    Scratch scratch;
    {
        std::vector<float> data;
        Imf::Header header = make_header(at_origin, Imf::ZIP_COMPRESSION, rgb);
        Imf::addComments(header, "no more than this");
        Imf::OutputFile file(scratch.path.c_str(), header);
        file.setFrameBuffer(slices(data, at_origin, rgb));
        file.writePixels(H);
    }
    expect_map(scratch.path, 0, false);
    std::vector<char> bytes(1 << 16);
    FILE *file = std::fopen(scratch.path.c_str(), "rb");
    bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file));
    std::fclose(file);
    static const char head[] = "comments\0string";
    auto at = std::search(bytes.begin(), bytes.end(), head, head + sizeof head);
    assert_true(at != bytes.end());
    at[sizeof head + 3] = 0x7f;
    file = std::fopen(scratch.path.c_str(), "wb");
    std::fwrite(bytes.data(), 1, bytes.size(), file);
    std::fclose(file);
    expect_refused(scratch.path, "its attribute comments has 2130706449 bytes");
    struct range_image image = {};
    Log log;
    struct stp_env env = {};
    env.log = keep;
    env.user = &log;
    assert_int_equal(range_image_read(&env, scratch.path.c_str(), RANGE_COLOR, &image),
                     STP_ERROR_FORMAT);
    assert_true(log.errors == 1 && log.last.find("its attribute comments") != std::string::npos);
}

/* Cut anywhere, or with a byte changed: a map or one line, never more. */
static void test_damaged(void **)
{
    Scratch whole, cut;
    write_lines(whole.path, at_origin, Imf::DWAA_COMPRESSION, rgb);
    std::vector<char> bytes(1 << 16);
    FILE *file = std::fopen(whole.path.c_str(), "rb");
    bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file));
    std::fclose(file);
    for (size_t i = 0; i < bytes.size(); i += i < 400 ? 3 : 97) {
        for (int change = 0; change < 2; change++) {
            std::vector<char> damaged = bytes;
            if (change)
                damaged[i] = static_cast<char>(damaged[i] ^ 0x41);
            else
                damaged.resize(i);
            file = std::fopen(cut.path.c_str(), "wb");
            std::fwrite(damaged.data(), 1, damaged.size(), file);
            std::fclose(file);
            struct environment_map map = {};
            Log log;
            enum stp_result result = read_map(cut.path, &map, &log);
            assert_true((result == STP_OK) == (map.texel != nullptr));
            assert_true(change || result != STP_OK);
            environment_map_release(&map);
        }
    }
}

static void test_memory(void **)
{
    Scratch scratch;
    write_tiles(scratch.path, at_origin, Imf::DWAB_COMPRESSION);
    struct environment_map map = {};
    Log log;
    mem_fail_at(1);
    assert_int_equal(read_map(scratch.path, &map, &log), STP_ERROR_MEMORY);
    mem_fail_at(0);
    assert_null(map.texel);
}

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_compressions),   cmocka_unit_test(test_grey),
        cmocka_unit_test(test_refused),        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_memory),         cmocka_unit_test(test_parts),
        cmocka_unit_test(test_huge_attribute),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
