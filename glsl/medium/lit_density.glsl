// Soft matter under the point light, by the gradient of the density as the DMFs have left it.
// Source: PH 3.1 (normals from the gradient of the density); MJ 6 (the lighting function is reused in the soft region).
// density: modulated, in [0, 1]; result: linear RGB.
// @knob gradient_step = 0.01 in [0.0001, 0.2]: Distance over which the density is compared, object units.
#include "lighting.glsl"
#include "density_normal.glsl"
vec3 medium(Sample s, float density) {
    return lighting(color.rgb * material_color.rgb, density_normal(s, density, gradient_step));
}
