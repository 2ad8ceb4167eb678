// No cell is known to be empty.
// Source: PH 3.1.
// x: object space; stride: of the ray, from one sample to the next, object space; k: number of the sample. Result: 0.
float empty_steps(vec3 x, vec3 stride, float k) { return 0.0; }
