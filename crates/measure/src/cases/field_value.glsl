// The stored distance in a plane across the voxels.
// Source: -
// Result: 0.5 + 0.25 of the distance at z = 0.3.
vec3 surface(Sample s) { return vec3(0.5 + 0.25 * object(vec3(s.x.xy, 0.3)).distance); }
