/* Push constants, for C and GLSL. Scalar layout: the offsets of C's structs. */
#ifndef STP_SHARED_PUSH_H
#define STP_SHARED_PUSH_H

#ifdef GL_core_profile
#define STP_PUSH_UINT(name) uint name
#define STP_PUSH_INT2(name) ivec2 name
#else
#include <stdint.h>
#define STP_PUSH_UINT(name) uint32_t name
#define STP_PUSH_INT2(name) int32_t name[2]
#endif

/* push_first: the first splat of a draw, or of those on the device, or the level of a pyramid;
 * push_count: of points; push_factor: what a draw's radii are multiplied by; push_shift: of its
 * slabs, in slabs. */
#define STP_PUSH                                                                                   \
    STP_PUSH_UINT(push_first);                                                                     \
    STP_PUSH_UINT(push_sample);                                                                    \
    STP_PUSH_UINT(push_count);                                                                     \
    float push_factor;                                                                             \
    float push_shift;

/* Then, of a host's frame, in pixels of its image: where the picture's corner is, and the part that
 * this tile covers. Hardware depth = add + scale / Z (orthographic: * Z), none where nothing is;
 * the largest finite value of the colour format; whether pixels without a surface are written too.
 */
#define STP_PUSH_HOST                                                                              \
    STP_PUSH_INT2(push_corner);                                                                    \
    STP_PUSH_INT2(push_low);                                                                       \
    STP_PUSH_INT2(push_high);                                                                      \
    float push_add;                                                                                \
    float push_scale;                                                                              \
    float push_none;                                                                               \
    float push_most;                                                                               \
    STP_PUSH_UINT(push_replace);

#ifndef GL_core_profile
struct stp_push {
    STP_PUSH
};
struct stp_push_host {
    STP_PUSH_HOST
};
#endif

#endif
