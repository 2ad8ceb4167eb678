// Debug look: the soft region as a tinted haze around the object.
// Source: MJ 3.1, Fig. 4.
// density: in [0, 1]; result: linear RGB.
vec3 medium(Sample s, float density) { return mix(vec3(0.1, 0.25, 1.0), vec3(0.2, 1.0, 0.6), density); }
