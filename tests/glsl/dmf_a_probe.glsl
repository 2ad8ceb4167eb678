// DMFs of the toolkit that know the density alone, at the density -0.5 + 2 t, t = 0.5 + 0.5 x.
// Source: PH 2.3.
// Result: half of what biased, gained and folded give.
#include "dmf/biased.glsl"
#include "dmf/gained.glsl"
#include "dmf/folded.glsl"
vec3 surface(Sample s) {
    float density = 0.5 + s.x.x;
    return 0.5 * vec3(biased(density, s), gained(density, s), folded(density, s));
}
