// Turbulence with four octaves in one fetch: channel c of the block holds the noise of octave c.
// Source: MJ 4.1 and Table 3 (4 channel); eight octaves are two fetches.
// p, width, enough and results: as octave_gradient.glsl has them; the channels are full, so that the gradient is that of
// differences over a texel: seven times the fetches.
// @exact procedural channel_block
// @loops 5
// @period memory
#include "octave_constants.glsl"
#include <filter>
#include <weights>

float turbulence(vec3 p, float width, float enough) {
    float sum = 0.0, scale = 1.0;
    for (int first = 0; first < OCTAVES; first += 4) {
        vec4 noise = abs(2.0 * lookup_block(channel_block, scale * p / channel_cells, 0.0) - 1.0);
        vec4 weight = vec4(octave_weight(scale * width), octave_weight(2.0 * scale * width),
                           octave_weight(4.0 * scale * width), octave_weight(8.0 * scale * width));
        vec4 wanted = vec4(lessThan(first + ivec4(0, 1, 2, 3), ivec4(OCTAVES)));
        sum += dot(mix(MEANS_IN_BLOCKS, noise, weight), wanted * vec4(1.0, 0.5, 0.25, 0.125)) / scale;
        if (sum >= enough) break;
        scale *= 16.0;
    }
    return sum;
}

vec4 turbulence_gradient(vec3 p, float width, float enough) {
    float h = 0.5 * channel_cells / float(textureSize(channel_block, 0).x);
    vec3 slope;
    for (int axis = 0; axis < 3; ++axis) {
        vec3 aside = vec3(0.0);
        aside[axis] = h;
        slope[axis] = turbulence(p + aside, width, ALL) - turbulence(p - aside, width, ALL);
    }
    return vec4(slope / (2.0 * h), turbulence(p, width, enough));
}
float turbulence(vec3 p, float width) { return turbulence(p, width, ALL); }
float turbulence(vec3 p) { return turbulence(p, 0.0, ALL); }
vec4 turbulence_gradient(vec3 p, float width) { return turbulence_gradient(p, width, ALL); }
vec4 turbulence_gradient(vec3 p) { return turbulence_gradient(p, 0.0, ALL); }
