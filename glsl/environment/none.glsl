// No surroundings: what a ray leaves behind stays transparent.
// Source: -
// from: of the ray, where it would have no width, object's center, axes of the eye; along: unit; spread: radians between rays of
// neighboring pixels; result: premultiplied linear RGBA.
vec4 environment(vec3 from, vec3 along, float spread) { return vec4(0.0); }
