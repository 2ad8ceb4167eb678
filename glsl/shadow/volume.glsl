// The light that reaches a place through the matter of the scene, from the shadow volume.
// Source: PH 4 and MJ 7 (shadows by preprocessing); M06 of the project.
// guess: what a medium assumes without shadows, unused; normal: of a hard surface, eye space, or 0 for soft matter.
// Result: transmittance in [0, 1].
// A hard surface looks up off itself: a texel along its normal and one toward the light, which clears every texel that
// the surface itself darkens. Less: it spots itself. More: light leaks in where things touch.
#include "light_space.glsl"
#include <filter>
vec3 shadow(float guess, vec3 normal) {
    vec3 off = normal == vec3(0.0) ? normal : normal + safe_normalize(light_position.xyz - position_eye, normal);
    vec3 place = to_light_space(position_eye + shadow_bias * off);
    float layers = shadow_side + 1.0;       // the light before and behind each segment
    return lookup_volume(shadow_volume, vec3(place.xy, (place.z * shadow_side + 0.5) / layers)).rrr;
}
