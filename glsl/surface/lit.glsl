// The material under the point light.
// Source: MJ 3.5, Fig. 7a.
// Result: linear RGB.
// @groom color
#include "lighting.glsl"
vec3 surface(Sample s) {
    vec3 own = color.rgb * material_color.rgb;
    groomed(own = groom_color(own, s.root);)
    return lighting(own, s.normal);
}
