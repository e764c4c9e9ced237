#include "load/lzf.h"

#include <string.h>

struct stream {
    const unsigned char *in, *in_end;
    unsigned char *begin, *out, *end;
};

/* 000LLLLL: L + 1 bytes follow as they are. */
static bool copy_literals(struct stream *s, unsigned control)
{
    size_t length = control + 1;
    if ((size_t)(s->in_end - s->in) < length || (size_t)(s->end - s->out) < length)
        return false;
    memcpy(s->out, s->in, length);
    s->in += length;
    s->out += length;
    return true;
}

/* LLLooooo oooooooo: L + 2 bytes from o + 1 bytes back; L of 7 is followed by a byte that is added
 * to it. The source may reach into what is being written. */
static bool copy_match(struct stream *s, unsigned control)
{
    size_t length = (control >> 5) + 2, back = (size_t)(control & 31) << 8;
    size_t needed = control >> 5 == 7 ? 2 : 1;
    if ((size_t)(s->in_end - s->in) < needed)
        return false;
    if (needed == 2)
        length += *s->in++;
    back += (size_t)*s->in++ + 1;
    if (back > (size_t)(s->out - s->begin) || length > (size_t)(s->end - s->out))
        return false;
    for (size_t i = 0; i < length; i++, s->out++)
        *s->out = *(s->out - back);
    return true;
}

bool lzf_unpack(const unsigned char *in, size_t in_size, unsigned char *out, size_t out_size,
                size_t *at)
{
    struct stream s = { in, in + in_size, out, out, out + out_size };
    while (s.in < s.in_end) {
        *at = (size_t)(s.in - in);
        unsigned control = *s.in++;
        if (!(control < 32 ? copy_literals(&s, control) : copy_match(&s, control)))
            return false;
    }
    *at = in_size;
    return s.out == s.end;
}
