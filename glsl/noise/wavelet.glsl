// Noise whose knots are constants instead of gradients: a wavelet at each lattice point, cheaper and worse.
// Source: PH 2.3, footnote: constant Gamma, with visible artifacts at the lattice points, where the gradient becomes 0.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 0.866 as of the other modules.
// @loops 9
#include "hash.glsl"
#include <weights>
#define NOISE_MEAN MEAN_OF_VALUES

vec4 noise_gradient(vec3 p) {
    vec3 inside = clamp(p, vec3(-1048576.0), vec3(1048576.0)), base = floor(inside);
    ivec3 cell = ivec3(base);
    vec3 w = fade(inside - base);
    vec3 dw = fade_slope(inside - base);
    vec4 sum = vec4(0.0);
    for (int corner = 0; corner < 8; ++corner) {
        ivec3 offset = ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        float knot = float(hash(uvec3(cell + offset)).x) * (1.7320508 / 4294967296.0) - 0.8660254;
        vec3 side = vec3(offset);
        vec3 weight = mix(1.0 - w, w, side);
        vec3 slope = dw * (2.0 * side - 1.0);
        sum += knot * vec4(slope.x * weight.y * weight.z,
                           slope.y * weight.x * weight.z,
                           slope.z * weight.x * weight.y,
                           weight.x * weight.y * weight.z);
    }
    return sum;
}
float noise(vec3 p) { return noise_gradient(p).w; }
