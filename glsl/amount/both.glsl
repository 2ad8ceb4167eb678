// How strong warps and DMFs are: as is painted in a groom, but nothing on the base that a scene keeps as it is.
// Source: ours.
// x: object space; results: a factor of the effect in [0, 2], and its gradient.
#include <groom>
#include "kept_base.glsl"
#include "amounts.glsl"
float effect_amount(vec3 x) { return above_base(x) * groom_amount(x); }
vec3 amount_slope(vec3 x) { return above_base(x) * groom_amount_slope(x) + groom_amount(x) * above_base_slope(x); }
