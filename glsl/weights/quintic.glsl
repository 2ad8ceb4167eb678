// Perlin's weights of 2002: the noise has a continuous curvature too.
// Source: Perlin 2002, named by MJ 2.3.
// t: in [0, 1] per axis; results: weight of the far side, and its slope. Means of |noise|, measured: of unit
// gradients at the lattice points; of these in a block, as a linear filter reads it from 16, 8, 4 and 2 texels a cell; of
// values as noise/wavelet.glsl has them.
const float MEAN_OF_GRADIENTS = 0.156, MEAN_OF_VALUES = 0.285;
const vec4 MEANS_IN_BLOCKS = vec4(0.155, 0.152, 0.141, 0.108);
vec3 fade(vec3 t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }
vec3 fade_slope(vec3 t) { return 30.0 * t * t * (t * (t - 2.0) + 1.0); }
