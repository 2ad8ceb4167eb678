// How strong warps and DMFs are: nothing on the base that a scene keeps as it is, and all above it.
// Source: ours.
// x: object space; results: a factor of the effect in [0, 1], and its gradient.
#include "kept_base.glsl"
#include "amounts.glsl"
float effect_amount(vec3 x) { return above_base(x); }
vec3 amount_slope(vec3 x) { return above_base_slope(x); }
