// Perspective projection: a ray at angle t to the axis travels 1 / cos t between two slices.
// Source: the correction is ours; without it the optical depth at the corner of a 90 degree view is 42 % short.
// Results: path per slice spacing, >= 1; unit direction to the eye, eye space.
// ndc: in [-1, 1], y down; depth: along the axis of view; result: eye space.
vec3 ray_at(vec2 ndc, float depth) { return vec3(ndc.x * ray_scale.x * depth, -ndc.y * ray_scale.y * depth, -depth); }
float path_scale() { return length(position_eye) / max(-position_eye.z, 1e-6); }
vec3 to_eye() { return safe_normalize(-position_eye, vec3(0.0, 0.0, 1.0)); }
