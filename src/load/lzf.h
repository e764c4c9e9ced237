/* LZF, the packing of binary_compressed PCD (Lehmann's LibLZF; the format is public). */
#ifndef STP_LOAD_LZF_H
#define STP_LOAD_LZF_H

#include <stdbool.h>
#include <stddef.h>

/* No three bytes unpack to more than this many. */
#define LZF_MOST_OF_THREE 264

/* Unpacks all of `in` to exactly `out_size` bytes. False: *at is the offset in `in` of the first
 * part that is damaged, or in_size when there was too little of it. */
bool lzf_unpack(const unsigned char *in, size_t in_size, unsigned char *out, size_t out_size,
                size_t *at);

#endif
