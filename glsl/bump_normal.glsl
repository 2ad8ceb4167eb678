// The normal of a bumpy surface: the volume's, turned by the noise's.
// Source: MJ 5.2, Eq. 7: normalize(k V + B). A larger k is a milder bump; where k V + B is 0 it has no direction: V.
// Eye space, to which MJ 5.2 transforms both before they are added; unit vectors.
// @param bump_scale = 1.6 in [0, 20]: k of Eq. 7: the smaller, the rougher the surface.
// @param bump_frequency = 7.0 in [0.5, 64]: Noise cells per object unit.
// @needs normal
#include "eye_normal.glsl"
#include <noise>
vec3 bumpmap(vec3 v, vec3 b, float k) { return safe_normalize(k * v + b, v); }

vec3 bump_normal(Sample s) {
    vec3 b = safe_normalize(noise_gradient(bump_frequency * s.x).xyz, s.normal);
    return bumpmap(eye_normal(s.normal), eye_normal(b), bump_scale);
}
