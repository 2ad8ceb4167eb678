// Burning gas: color by density through the transfer map, with relief from the gradient of the turbulence.
// Source: PH 2.4 (low density red, high yellow); MJ Fig. 7f: fire (bumpy).
// density: modulated, in [0, 1]; result: linear RGB.
// @needs normal
// @drift relief_rise * 2
// @param relief = 0.35 in [0, 1]: Strength of the relief.
// @param relief_rise = 0.6 in [0, 8]: Speed at which the relief rises, object units per second: that of the flames.
// @param glow = 1.6 in [0, 10]: Brightness of the gas.
// @param flame_opacity = 1 in [0, 4]: How opaque the gas is, as a part of the opacity rate: beside fur, little.
#include "eye_normal.glsl"
#include <transfer>
#include <turbulence>
#include <phases>
vec3 medium(Sample s, float density) {
    vec3 p = 2.0 * (s.x - vec3(0.0, relief_rise * time, 0.0));
    vec4 bumps = turbulence_gradient(p, 2.0 * sample_width());
    SECOND_PHASE(
        vec3 velocity = vec3(0.0, -2.0 * relief_rise, 0.0);
        bumps = passing(bumps, turbulence_gradient(earlier(p, velocity), 2.0 * sample_width()), velocity, SUM_RANGE);
    )
    vec3 b = safe_normalize(bumps.xyz, s.normal);
    vec3 wide = length(s.wide_normal) * eye_normal(s.wide_normal);
    vec3 n = safe_normalize(wide + eye_normal(b), to_eye());   // MJ 5.2: added in eye space
    float lit = clamp(0.5 + 0.5 * dot(n, safe_normalize(light_position.xyz - position_eye, n)), 0.0, 1.0);
    return glow * transfer(density).rgb * mix(1.0, 0.35 + 1.1 * lit, relief);
}
float extinction(Sample s, float density) { return flame_opacity; }
