// Bump mapping with two normals: the volume's and the noise's.
// Source: MJ 5.2, Eq. 7, Fig. 7c.
// Result: linear RGB.
#include "bump_normal.glsl"
#include "lighting.glsl"
vec3 surface(Sample s) { return eye_lighting(color.rgb * material_color.rgb, bump_normal(s)); }
