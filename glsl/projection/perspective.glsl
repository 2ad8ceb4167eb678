// Perspective projection: a ray at angle t to the axis travels 1 / cos t between two slices.
// Source: the correction is ours; without it the optical depth at the corner of a 90 degree view is 42 % short.
// Results: path per slice spacing, >= 1; unit direction to the eye, eye space.
// ray_basis_of: columns are unit vectors along the ray and to two sides of it, eye space: once per ray (PH 3.1).
// pixel_width: at the depth of the sample, eye space.
// ndc: in [-1, 1], y down; depth: along the axis of view; result: eye space.
#include <planes>
vec3 ray_at(vec2 ndc, float depth) { return vec3(ndc.x * ray_scale.x * depth, -ndc.y * ray_scale.y * depth, -depth); }
float path_scale() { return length(position_eye) / max(abs(plane_depth(position_eye)), 1e-6); }
vec3 to_eye() { return safe_normalize(-position_eye, vec3(0.0, 0.0, 1.0)); }
mat3 ray_basis_of() {
    vec3 along = -to_eye();
    vec3 side = normalize(vec3(-along.z, 0.0, along.x));     // no ray is vertical: a view has less than 180 degrees
    return mat3(along, side, cross(side, along));
}
float pixel_width() { return ray_scale.y * picture_scale.y * max(-position_eye.z, 0.0); }
