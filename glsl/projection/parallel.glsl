// Parallel projection: every ray crosses the slices at a right angle.
// Source: MJ 2 and Fig. 1.
// Results: path per slice spacing, 1; unit direction to the eye, eye space.
float path_scale() { return 1.0; }
vec3 to_eye() { return vec3(0.0, 0.0, 1.0); }
