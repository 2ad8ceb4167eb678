// Parallel projection: every ray crosses the slices at a right angle.
// Source: MJ 2 and Fig. 1.
// Results: path per slice spacing, 1; unit direction to the eye, eye space.
// ndc: in [-1, 1], y down; depth: along the axis of view; result: eye space.
vec3 ray_at(vec2 ndc, float depth) { return vec3(ndc.x * ray_scale.x, -ndc.y * ray_scale.y, -depth); }
float path_scale() { return 1.0; }
vec3 to_eye() { return vec3(0.0, 0.0, 1.0); }
