// Soft matter carved out of the same block of turbulence as the surface, lit.
// Source: MJ 5.1 and 6; PH 2.4 (the eroded cube is colored by turbulence).
// density: modulated, in [0, 1]; result: linear RGB.
#include "solid_texture.glsl"
#include "lighting.glsl"
vec3 medium(Sample s, float density) { return lighting(solid_texture(s.x), s.shading); }
