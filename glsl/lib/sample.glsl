#ifndef SAMPLE_GLSL
#define SAMPLE_GLSL
// Where in a pixel its ray goes (docs/numerics.md, "Samples"): the pass is run once a sample.

uint sample_mix(uint h)
{
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

// Of a pixel of the whole picture, from its corner.
vec2 sample_part(uvec2 pixel)
{
    if (SAMPLE_GRID == 1)
        return vec2(0.5);
    uint h = sample_mix(sample_mix(sample_mix(pixel.x + 0x9e3779b9u) + pixel.y) + push_sample);
    vec2 cell = vec2(push_sample % SAMPLE_GRID, push_sample / SAMPLE_GRID);
    return (cell + (vec2(h >> 16, h & 0xffffu) + 0.5) / 65536.0) / float(SAMPLE_GRID);
}
#endif
