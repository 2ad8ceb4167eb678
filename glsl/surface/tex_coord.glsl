// Debug look: texture coordinates as colors.
// Source: MJ 3.3, Fig. 3b.
// Result: linear RGB, 0 to 1 across the box around the object.
vec3 surface(Sample s) { return (s.x - own_min.xyz) / (own_max.xyz - own_min.xyz); }
