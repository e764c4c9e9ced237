// Depth and colour from OpenEXR, through its C++ library; no exception leaves this file.
#include "load/exr_bytes.hpp"
#include "load/range.h"

#include <ImfFrameBuffer.h>
#include <ImfInputPart.h>
#include <ImfPartType.h>

namespace
{

/* Of a depth Z, else Y; of a colour R G B, else Y. None: nullptr. */
const char *const *wanted(const Imf::ChannelList &channels, enum range_plane plane, unsigned *count)
{
    static const char *const depth[] = { "Z" }, *const grey[] = { "Y" },
                             *const color[] = { "R", "G", "B" };
    const bool three = channels.findChannel("R") && channels.findChannel("G") &&
                       channels.findChannel("B") && plane == RANGE_COLOR;
    const bool deep = channels.findChannel("Z") && plane == RANGE_DEPTH;
    *count = three ? 3 : 1;
    return three ? color : deep ? depth : channels.findChannel("Y") ? grey : nullptr;
}

enum stp_result check_channels(const struct stp_env *env, const char *path,
                               const Imf::ChannelList &channels, enum range_plane plane)
{
    unsigned count;
    const char *const *names = wanted(channels, plane, &count);
    if (!names)
        return log_error(env, STP_ERROR_FORMAT, "%s: it has no %s, nor a channel Y", path,
                         plane == RANGE_DEPTH ? "channel Z" : "channels R G B");
    return exr_check_sampling(env, path, channels, names, count);
}

void read_pixels(Imf::MultiPartInputFile &file, enum range_plane plane, struct range_image *image)
{
    unsigned count;
    const Imf::Header &header = file.header(0);
    const char *const *names = wanted(header.channels(), plane, &count);
    const Imath::Box2i window = header.dataWindow();
    const size_t texel = count * sizeof *image->value;
    Imf::FrameBuffer frame;
    for (unsigned i = 0; i < count; i++)
        frame.insert(names[i], Imf::Slice::Make(Imf::FLOAT, image->value + i, window, texel,
                                                texel * image->width));
    Imf::InputPart part(file, 0);
    part.setFrameBuffer(frame);
    part.readPixels(window.min.y, window.max.y);
}

enum stp_result read_file(const struct stp_env *env, const char *path,
                          const struct file_bytes *bytes, enum range_plane plane,
                          struct range_image *image)
{
    ExrBytes stream(path, bytes);
    Imf::MultiPartInputFile file(stream, 0, false);
    const Imf::Header &header = file.header(0);
    unsigned count;
    exr_warn_of_parts(env, path, file);
    if (header.hasType() && Imf::isDeepData(header.type()))
        return log_error(env, STP_ERROR_FORMAT, "%s: a deep EXR; a frame is flat", path);
    enum stp_result result = check_channels(env, path, header.channels(), plane);
    if (result != STP_OK)
        return result;
    const ExrSize size = exr_size(header);
    wanted(header.channels(), plane, &count);
    result = range_allocate(env, path, size.width, size.height, count, image);
    if (result == STP_OK)
        read_pixels(file, plane, image);
    return result;
}

} // namespace

enum stp_result range_read_exr(const struct stp_env *env, const char *path,
                               const struct file_bytes *bytes, enum range_plane plane,
                               struct range_image *image)
{
    struct range_image read = {};
    enum stp_result result =
        exr_guarded(env, path, bytes, [&] { return read_file(env, path, bytes, plane, &read); });
    if (result == STP_OK)
        *image = read;
    else
        range_image_release(&read);
    return result;
}
