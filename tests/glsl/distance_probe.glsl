// The signed distance itself.
// Source: MJ 3.1.
// Result: 0.5 + 0.25 distance.
vec3 surface(Sample s) { return vec3(0.5 + 0.25 * s.distance); }
