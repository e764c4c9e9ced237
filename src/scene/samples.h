/* Stratified sample positions (docs/numerics.md, "Samples"). */
#ifndef STP_SCENE_SAMPLES_H
#define STP_SCENE_SAMPLES_H

#include <stdint.h>

/* The side of the smallest square grid that holds `samples` (0 counts as 1). */
unsigned sample_grid(unsigned samples);

/* Position of sample `index` of grid * grid of pixel (i, j). */
void sample_position(unsigned grid, uint32_t i, uint32_t j, uint32_t index, double *px, double *py);

#endif
