// Surroundings without edges: the color is the direction of view.
// Source: -
// Result: linear RGB, opaque.
vec4 environment(vec3 from, vec3 along, float spread) { return vec4(0.5 + 0.5 * along, 1.0); }
