// The normal in eye space, as lighting reads it.
// Source: MJ 3.5.
// Result: each component c as 0.5 + 0.5 c.
// @needs normal
vec3 surface(Sample s) { return 0.5 + 0.5 * safe_normalize(mat3(normal_matrix) * s.normal, to_eye()); }
