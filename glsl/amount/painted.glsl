// How strong warps and DMFs are: as is painted in a groom.
// Source: ours.
// x: object space; results: a factor of the effect in [0, 2], and its gradient.
#include <groom>
#include "amounts.glsl"
float effect_amount(vec3 x) { return groom_amount(x); }
vec3 amount_slope(vec3 x) { return groom_amount_slope(x); }
