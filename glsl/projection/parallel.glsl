// Parallel projection: every ray crosses the slices at a right angle.
// Source: MJ 2 and Fig. 1.
// Results: path per slice spacing, 1; unit direction to the eye, eye space.
// ray_basis_of: columns are unit vectors along the ray and to two sides of it, eye space: the same for all rays, so the
// compiler has it once per image (PH 3.1). pixel_width: eye space.
// ndc: in [-1, 1], y down; depth: along the axis of view; result: eye space.
#include <planes>
vec3 ray_at(vec2 ndc, float depth) { return vec3(ndc.x * ray_scale.x, -ndc.y * ray_scale.y, -depth); }
float path_scale() { return 1.0 / max(abs(plane_depth(vec3(0.0, 0.0, 1.0))), 1e-6); }
vec3 to_eye() { return vec3(0.0, 0.0, 1.0); }
mat3 ray_basis_of() { return mat3(vec3(0.0, 0.0, -1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)); }
float pixel_width() { return ray_scale.y * picture_scale.y; }
