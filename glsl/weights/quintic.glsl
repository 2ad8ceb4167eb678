// Perlin's weights of 2002: the noise has a continuous curvature too.
// Source: Perlin 2002, named by MJ 2.3.
// t: in [0, 1] per axis; results: weight of the far side, and its slope.
vec3 fade(vec3 t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }
vec3 fade_slope(vec3 t) { return 30.0 * t * t * (t * (t - 2.0) + 1.0); }
