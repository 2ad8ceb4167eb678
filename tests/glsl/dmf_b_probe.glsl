// More DMFs of the toolkit that know the density alone.
// Source: PH 2.3.
// Result: scaled as 0.5 + 0.1 of it, waves as 0.5 + 0.25 of it, the part of the soft region.
#include "dmf/scaled.glsl"
#include "dmf/waves.glsl"
#include "soft_part.glsl"
vec3 surface(Sample s) {
    float density = 0.5 + s.x.x;
    s.density = 0.5 + 0.5 * s.x.x;
    return vec3(0.5 + 0.1 * scaled(density, s), 0.5 + 0.25 * waves(density, s), soft_part(s));
}
