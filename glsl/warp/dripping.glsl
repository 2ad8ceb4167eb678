// Noise moves the y component alone: the object runs down in drips.
// Source: PH 2.4 (dripping sphere: noise modulates only the y component of x); the paper prints no formula: a
// reconstruction. The noise varies slowly along y, so that a drip stays a drip, and what would rise is held low.
// x: object space; jacobian: derivative of the displaced by the original point.
// @move +y 1.1547006 * noise_bound * drip_amplitude
// @move -y 0.2886752 * noise_bound * drip_amplitude
// @param drip_amplitude = 0.8 in [0, 2]: Length of the longest drip, object units.
// @param drips = 3 in [0.2, 20]: Drips per object unit.
#include <noise>
void dripping(inout vec3 x, inout mat3 jacobian) {
    vec3 scale = drips * vec3(1.0, 0.2, 1.0);
    vec4 n = noise_gradient(scale * x);
    float side = drip_amplitude / 0.8660254 * (n.w > 0.0 ? 1.0 : 0.25);    // the noise reaches 0.866
    vec3 slope = side * scale * n.xyz;
    x.y += side * n.w;
    jacobian = mat3(1.0, slope.x, 0.0, 0.0, 1.0 + slope.y, 0.0, 0.0, slope.z, 1.0) * jacobian;
}
