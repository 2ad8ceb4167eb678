// Solid texture, lit: the object is carved out of a block of turbulence.
// Source: MJ 5.1, Fig. 2 and 7b.
// Result: linear RGB.
#include "solid_texture.glsl"
#include "lighting.glsl"
vec3 surface(Sample s) { return lighting(solid_texture(s.x), s.normal); }
