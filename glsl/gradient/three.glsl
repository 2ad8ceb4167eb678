// The gradient of the modulated density from three differences: to the sample before on the ray, whose density is known
// to a ray that has just been there, and to two places beside the ray. One-sided: an error of the order of the step.
// Source: PH 3.1: f(x) - f(x - dx_mu), f(x + dx_nu) - f(x), f(x + dx_omega) - f(x).
// s: a sample with 0 < density < 1; path: of the step, object units; result: unit normal, object space.
// @places 3
#include "modulated.glsl"
float density_before = -1.0;    // of the sample before on this ray; less than 0 where it is not known

vec3 shading_normal(Sample s, float density, float path) {
    mat3 offset = mat3(texture_matrix) * (ray_basis * path);
    float before = density_before;
    if (!follows || before < 0.0) before = modulated_density(s.x - offset[0]);
    return normal_of(vec3(density - before,
                          modulated_density(s.x + offset[1]) - density,
                          modulated_density(s.x + offset[2]) - density), s.normal);
}
void remember(float density) { density_before = density; }
void enter(inout Sample s, inout float density, float path) {}
