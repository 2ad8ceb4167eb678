// Solid texture, unlit.
// Source: MJ 5.1.
// Result: linear RGB.
#include "solid_texture.glsl"
vec3 surface(Sample s) { return solid_texture(s.x); }
