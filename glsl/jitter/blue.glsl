// Each pixel has its own phase of the steps, of a tile of blue noise: neighbors are far apart, so that what is left of the
// contours of the steps is fine grain, which an eye or a filter takes for their mean.
// Source: PH 3.1 (jittered step phase); the tile is Ulichney's 1993 (void and cluster); ours: all phases move by the golden
// ratio from one sub-frame to the next, so that those of a pixel cover the step evenly.
// Result: phase in [-1/2, 1/2) steps, uniform over the tile and over the seeds.
#include "pixel.glsl"
float sample_phase() {
    ivec2 at = ivec2(pixel_center) & (textureSize(phase_tile, 0) - 1);
    return fract(texelFetch(phase_tile, at, 0).r + jitter_seed / 16777216.0) - 0.5;
}
#include "shift_sample.glsl"
