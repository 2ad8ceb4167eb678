// Soft matter under the same point light as the surface.
// Source: MJ 6 (the lighting function is reused in the soft region).
// density: modulated, in [0, 1]; result: linear RGB.
#include "lighting.glsl"
vec3 medium(Sample s, float density) { return lighting(color.rgb * material_color.rgb, s.shading); }
