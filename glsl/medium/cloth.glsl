// Threads of two colors, lit by the gradient of the density and darker where they dive under one another.
// Source: PH 1 (woven materials), PH 3.1 (gradient): a reconstruction. Needs the DMF `woven`, and effect.gradient to be
// `central` or `three`.
// @needs normal
// @groom color
// density: modulated, in [0, 1]; result: linear RGB.
// @color warp_color = #b03a2e: Color of the threads that run up and down.
// @color weft_color = #e8d5a8: Color of the threads that run around.
#include "lighting.glsl"
vec3 medium(Sample s, float density) {
    vec2 depth = thread_depths(s);
    vec3 base = depth.x > depth.y ? warp_color.rgb : weft_color.rgb;
    float buried = clamp(s.density, 0.0, 1.0);
    groomed(base = groom_color(base, s.root);)
    return lighting(color.rgb * base, s.shading) * mix(1.0, 0.35, buried * buried);
}
