// No surroundings: what a ray leaves behind stays transparent.
// Source: -
// from: object's center, axes of the eye; along: unit; result: premultiplied linear RGBA.
vec4 environment(vec3 from, vec3 along) { return vec4(0.0); }
