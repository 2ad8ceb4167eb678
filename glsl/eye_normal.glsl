// A normal in eye space, of one in object space.
// Source: MJ 3.3, 3.5: by the inverse transpose.
// Result: unit; toward the eye for a normal of length 0.
vec3 eye_normal(vec3 normal) { return safe_normalize(mat3(normal_matrix) * normal, to_eye()); }
