// Fire: a soft region that is wider above the object than below it, torn into tongues by turbulence that rises.
// Source: PH 2.4 (fire ball: D(x (1 + turbulence(x)))), MJ 6 (fire varying with height); the form is a reconstruction.
// density: D in [0, 1]; result in [0, 1]. Leaves the wide normal to the medium where flames are.
// @groom length density
// @outer flame_length
// @drift rise * 0.45 * flame_scale
// @param flame_length = 0.5 in [0.01, 1.5]: Length of the flames above the object, object units.
// @param flame_scale = 3.0 in [0.2, 20]: Fineness of the tongues: turbulence cells per object unit.
// @param fury = 1.5 in [0, 4]: How deep the turbulence cuts into the flames.
// @param rise = 0.6 in [0, 8]: Speed of the flames, object units per second.
#include "sample.glsl"
#include <turbulence>
#include <phases>

// The gradient of the distance over half of it to each side, at most 1 long: four places, the corners of a tetrahedron.
// The normal jumps where the nearest surface changes sides, and flames would have a crease there; a difference of
// distances does not, and between two sides it is short.
vec3 wide_normal(Sample s) {
    float reach = max(0.5 * (s.distance - iso_value), 1e-3);
    const vec3 A = vec3(1.0, -1.0, -1.0), B = vec3(-1.0, 1.0, -1.0), C = vec3(-1.0, -1.0, 1.0), D = vec3(1.0);
    vec3 sum = A * sample_object(s.x + reach * A).distance + B * sample_object(s.x + reach * B).distance
             + C * sample_object(s.x + reach * C).distance + D * sample_object(s.x + reach * D).distance;
    return sum / (4.0 * reach);
}

float fire(float density, inout Sample s) {
    if (density >= 1.0) return 1.0;
    float height = clamp((s.x.y - own_min.y) / (own_max.y - own_min.y), 0.0, 1.0);
    float deep = fury * mix(0.8, 1.5, height);                   // MJ 6: varying with height
    vec3 p = flame_scale * vec3(1.0, 0.45, 1.0) * (s.x - vec3(0.0, rise * time, 0.0));
    // Nothing is left even of a flame as long as flames get, upward, where the fetches of the gradient are saved.
    float most = 1.0001 * density + 1e-6, rate = deep * (1.35 - density), enough = most / max(rate, 1e-6);
    float torn = turbulence(p, flame_scale * sample_width(), UNTIL(enough));
    SECOND_PHASE(
        vec3 velocity = vec3(0.0, -0.45 * flame_scale * rise, 0.0);
        float before = turbulence(earlier(p, velocity), flame_scale * sample_width(), ALL);
        torn = passing(torn, before, velocity, SUM_RANGE);
    )
    if (rate * torn >= most) return 0.0;
    s.wide_normal = wide_normal(s);
    float up = smoothstep(-0.8, 0.9, s.wide_normal.y);
    float reach = mix(0.22, 1.0, up);                            // of the flame length, in this direction
    float away = clamp((1.0 - density) / reach, 0.0, 1.0);       // 0 at the object, 1 at the tip of a flame
    groomed(vec3 foot = s.x - (s.distance - iso_value) * s.wide_normal;)
    groomed(away = min(away / clamp(groom_length(foot), 1e-3, 1.0), 1.0);)
    float left = 1.0 - away - deep * (0.35 + away) * torn;
    // The gas stands off from the object: it is thinnest there, so that slices leave no contours on the surface, also where
    // flames are short.
    return 0.85 * clamp(1.4 * left, 0.0, 1.0) * smoothstep(0.0, 0.15, 1.0 - density) groomed(* min(groom_density(foot), 1.0));
}
