// Bump mapping with two normals: the volume's and the noise's.
// Source: MJ 5.2, Eq. 7, Fig. 7c.
// Result: linear RGB.
// @groom color
#include "bump_normal.glsl"
#include "lighting.glsl"
vec3 surface(Sample s) {
    vec3 own = color.rgb * material_color.rgb;
    groomed(own = groom_color(own, s.root);)
    return eye_lighting(own, bump_normal(s));
}
