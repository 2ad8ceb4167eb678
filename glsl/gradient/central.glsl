// The gradient of the modulated density by central differences: six densities, an error of the order of the step squared.
// Dense matter is shaded where the ray enters it, and its gradient is taken there.
// Source: PH 3.1 (gradient of f).
// s: a sample with 0 < density < 1; path: of the step, object units; result: unit normal, object space.
// @places 6
#include "entered.glsl"
vec3 shading_normal(Sample s, float density, float path) {
    mat3 offset = mat3(texture_matrix) * (ray_basis * path);
    vec3 ahead = vec3(modulated_density(s.x + offset[0]),
                      modulated_density(s.x + offset[1]),
                      modulated_density(s.x + offset[2]));
    vec3 behind = vec3(modulated_density(s.x - offset[0]),
                       modulated_density(s.x - offset[1]),
                       modulated_density(s.x - offset[2]));
    return normal_of(ahead - behind, s.normal);
}
void remember(float density) {}
