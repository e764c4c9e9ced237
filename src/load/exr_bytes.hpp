// A file in memory, as OpenEXR's C++ library reads one, and what its readers share.
#ifndef STP_LOAD_EXR_BYTES_HPP
#define STP_LOAD_EXR_BYTES_HPP

#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfMultiPartInputFile.h>

#include "base/file.h"

extern "C" {
#include "base/log.h"
}

class ExrBytes : public Imf::IStream
{
  public:
    ExrBytes(const char *path, const file_bytes *bytes)
        : IStream(path), data(bytes->data), size(bytes->size), at(0)
    {
    }
    bool read(char out[], int count) override
    {
        if (count < 0 || static_cast<uint64_t>(count) > size - at)
            throw std::runtime_error("it ends too early");
        std::memcpy(out, data + at, static_cast<size_t>(count));
        at += static_cast<uint64_t>(count);
        return at < size;
    }
    uint64_t tellg() override
    {
        return at;
    }
    void seekg(uint64_t to) override
    {
        if (to > size)
            throw std::runtime_error("it points beyond its end");
        at = to;
    }

  private:
    const unsigned char *data;
    uint64_t size, at;
};

// Of several parts the first is read, which is said.
inline void exr_warn_of_parts(const struct stp_env *env, const char *path,
                              const Imf::MultiPartInputFile &file)
{
    const Imf::Header &header = file.header(0);
    if (file.parts() > 1)
        log_warning(env, "%s: of its %d parts only the first is read: \"%s\"", path, file.parts(),
                    header.hasName() ? header.name().c_str() : "");
}

// The library takes room for an attribute before it reads it: one that goes beyond the end of the
// file is refused before the library sees the header. What else is wrong with it the library says.
inline enum stp_result exr_check_header(const struct stp_env *env, const char *path,
                                        const struct file_bytes *bytes)
{
    const uint64_t size = bytes->size;
    const bool multipart = size > 8 && (bytes->data[5] & 0x10) != 0;
    uint64_t at = 8;
    while (at < size) {
        const unsigned char *const start = bytes->data + at;
        if (*start == 0) { // a header's end; of several, one more ends them
            at++;
            if (!multipart || at == size || bytes->data[at] == 0)
                return STP_OK;
            continue;
        }
        for (int i = 0; i < 2; i++) { // its name, its type
            const void *end = std::memchr(bytes->data + at, 0, size - at);
            if (!end)
                return STP_OK;
            at = static_cast<uint64_t>(static_cast<const unsigned char *>(end) - bytes->data) + 1;
        }
        if (size - at < 4)
            return STP_OK;
        uint64_t length = 0;
        for (int i = 0; i < 4; i++)
            length |= static_cast<uint64_t>(bytes->data[at + static_cast<uint64_t>(i)]) << (8 * i);
        at += 4;
        if (length > size - at)
            return log_error(
                env, STP_ERROR_FORMAT,
                "%s: damaged: its attribute %.40s has %llu bytes, beyond the end of the "
                "file",
                path, reinterpret_cast<const char *>(start),
                static_cast<unsigned long long>(length));
        at += length;
    }
    return STP_OK;
}

// What `read` returns, or, of an exception, which leaves no file, what it means.
template <typename Read>
enum stp_result exr_guarded(const struct stp_env *env, const char *path,
                            const struct file_bytes *bytes, Read read)
{
    const enum stp_result checked = exr_check_header(env, path, bytes);
    if (checked != STP_OK)
        return checked;
    try {
        return read();
    } catch (const std::bad_alloc &) {
        return log_error(env, STP_ERROR_MEMORY, "%s: out of memory", path);
    } catch (const std::exception &failure) {
        return log_error(env, STP_ERROR_FORMAT, "%s: damaged: %s", path, failure.what());
    }
}

// Every channel named is there; each must have all its pixels.
inline enum stp_result exr_check_sampling(const struct stp_env *env, const char *path,
                                          const Imf::ChannelList &channels,
                                          const char *const *names, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        const Imf::Channel *channel = channels.findChannel(names[i]);
        if (channel->xSampling != 1 || channel->ySampling != 1)
            return log_error(env, STP_ERROR_FORMAT, "%s: channel %s is subsampled", path, names[i]);
    }
    return STP_OK;
}

// Of the data window; 0 where a damaged header has it the wrong way round.
struct ExrSize {
    uint64_t width, height;
};
inline ExrSize exr_size(const Imf::Header &header)
{
    const Imath::Box2i window = header.dataWindow();
    const int64_t width = static_cast<int64_t>(window.max.x) - window.min.x + 1;
    const int64_t height = static_cast<int64_t>(window.max.y) - window.min.y + 1;
    return { width > 0 ? static_cast<uint64_t>(width) : 0,
             height > 0 ? static_cast<uint64_t>(height) : 0 };
}

#endif
