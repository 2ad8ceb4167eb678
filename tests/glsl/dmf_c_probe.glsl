// DMFs of the toolkit that know the place, at the density 0.3 of the middle of the soft region.
// Source: PH 2.3, 2.4.
// Result: 0.5 + 0.25 of what noisy, fractal and turbulent give.
#include "dmf/noisy.glsl"
#include "dmf/fractal.glsl"
#include "dmf/turbulent.glsl"
vec3 surface(Sample s) {
    s.density = 0.5;
    s.x.z = 0.37;
    return 0.5 + 0.25 * vec3(noisy(0.3, s), fractal(0.3, s), turbulent(0.3, s));
}
