// A file in memory, as OpenEXR's C++ library reads one.
#ifndef STP_LOAD_EXR_BYTES_HPP
#define STP_LOAD_EXR_BYTES_HPP

#include <cstring>
#include <stdexcept>

#include <ImfIO.h>

#include "base/file.h"

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

#endif
