// Solid texture, lit: the object is carved out of a block of turbulence.
// Source: MJ 5.1, Fig. 2 and 7b.
// Result: linear RGB.
// @groom color
#include "solid_texture.glsl"
#include "lighting.glsl"
vec3 surface(Sample s) {
    vec3 own = solid_texture(s.x);
    groomed(own = groom_color(own, s.root);)
    return lighting(own, s.normal);
}
