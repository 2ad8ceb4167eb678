// The moment of each ray that meets the surroundings: a constant along its line.
// Source: Bouguer's invariant is n times its length.
// Result: from x along, opaque.
vec4 environment(vec3 from, vec3 along, float spread) { return vec4(cross(from, along), 1.0); }
