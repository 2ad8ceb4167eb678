// The material under the point light.
// Source: MJ 3.5, Fig. 7a.
// Result: linear RGB.
#include "lighting.glsl"
vec3 surface(Sample s) { return lighting(color.rgb * material_color.rgb, s.normal); }
