// OpenEXR maps through its C++ library; nothing of it leaves this file, exceptions least of all.
#include "load/environment.h"
#include "load/exr_bytes.hpp"

#include <ImfFrameBuffer.h>
#include <ImfInputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>

namespace
{

const char *refusal(const Imf::Header &header)
{
    if (header.hasType() && Imf::isDeepData(header.type()))
        return "a deep EXR; an environment map is flat";
    if (Imf::hasEnvmap(header) && Imf::envmap(header) == Imf::ENVMAP_CUBE)
        return "a cube map; only latitude-longitude maps are read (exrenvmap -l converts it)";
    return nullptr;
}

bool has(const Imf::ChannelList &channels, const char *name)
{
    return channels.findChannel(name) != nullptr;
}

bool in_color(const Imf::ChannelList &channels)
{
    return has(channels, "R") && has(channels, "G") && has(channels, "B");
}

enum stp_result check_channels(const struct stp_env *env, const char *path,
                               const Imf::ChannelList &channels)
{
    static const char *const color[] = { "R", "G", "B" }, *const grey[] = { "Y" };
    const bool three = in_color(channels);
    if (!three && (!has(channels, "Y") || has(channels, "RY")))
        return log_error(env, STP_ERROR_FORMAT, "%s: it has no channels R G B, nor Y alone", path);
    return exr_check_sampling(env, path, channels, three ? color : grey, three ? 3 : 1);
}

/* Grey is read once, as red. */
void read_pixels(Imf::MultiPartInputFile &file, struct environment_map *map)
{
    static const char *const names[] = { "R", "G", "B" };
    const Imf::Header &header = file.header(0);
    const Imath::Box2i window = header.dataWindow();
    const size_t texel = sizeof *map->texel, row = texel * map->width;
    const bool grey = !in_color(header.channels());
    Imf::FrameBuffer frame;
    for (int i = 0; i < (grey ? 1 : 3); i++)
        frame.insert(grey ? "Y" : names[i],
                     Imf::Slice::Make(Imf::FLOAT, &map->texel[0][i], window, texel, row));
    Imf::InputPart part(file, 0);
    part.setFrameBuffer(frame);
    part.readPixels(window.min.y, window.max.y);
    for (size_t i = 0; grey && i < static_cast<size_t>(map->width) * map->height; i++)
        map->texel[i][1] = map->texel[i][2] = map->texel[i][0];
}

enum stp_result read_file(const struct stp_env *env, const char *path,
                          const struct file_bytes *bytes, struct environment_map *map)
{
    ExrBytes stream(path, bytes);
    Imf::MultiPartInputFile file(stream, 0, false);
    const Imf::Header &header = file.header(0);
    exr_warn_of_parts(env, path, file);
    const char *refused = refusal(header);
    if (refused)
        return log_error(env, STP_ERROR_FORMAT, "%s: %s", path, refused);
    enum stp_result result = check_channels(env, path, header.channels());
    if (result != STP_OK)
        return result;
    /* Before any line buffer: a damaged header may ask for terabytes. */
    const ExrSize size = exr_size(header);
    result = environment_allocate(env, path, size.width, size.height, map);
    if (result == STP_OK)
        read_pixels(file, map);
    return result;
}

} // namespace

bool environment_is_exr(const struct file_bytes *bytes)
{
    return bytes->size > 4 && std::memcmp(bytes->data, "\x76\x2f\x31\x01", 4) == 0;
}

enum stp_result environment_read_exr(const struct stp_env *env, const char *path,
                                     const struct file_bytes *bytes, struct environment_map *map)
{
    struct environment_map read = {};
    enum stp_result result =
        exr_guarded(env, path, bytes, [&] { return read_file(env, path, bytes, &read); });
    if (result == STP_OK)
        *map = read;
    else
        environment_map_release(&read);
    return result;
}
