// Perlin's weights of 1989: the noise has a continuous gradient, with a crease in its curvature at lattice planes.
// Source: PH 2.3: 2|t|^3 - 3t^2 + 1, here as its complement.
// t: in [0, 1] per axis; results: weight of the far side, and its slope.
vec3 fade(vec3 t) { return t * t * (3.0 - 2.0 * t); }
vec3 fade_slope(vec3 t) { return 6.0 * t * (1.0 - t); }
