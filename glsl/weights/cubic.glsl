// Perlin's weights of 1989: the noise has a continuous gradient, with a crease in its curvature at lattice planes.
// Source: PH 2.3: 2|t|^3 - 3t^2 + 1, here as its complement.
// t: in [0, 1] per axis; results: weight of the far side, and its slope. Means of |noise|, measured: of unit
// gradients at the lattice points; of these in a block, as a linear filter reads it from 16, 8, 4 and 2 texels a cell; of
// values as noise/wavelet.glsl has them.
const float MEAN_OF_GRADIENTS = 0.148, MEAN_OF_VALUES = 0.261;
const vec4 MEANS_IN_BLOCKS = vec4(0.147, 0.145, 0.135, 0.105);
vec3 fade(vec3 t) { return t * t * (3.0 - 2.0 * t); }
vec3 fade_slope(vec3 t) { return 6.0 * t * (1.0 - t); }
