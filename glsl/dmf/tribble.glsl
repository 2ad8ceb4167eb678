// Curly fur: straight at the root, ever curlier towards the tip.
// Source: PH 2.4 (tribble): x' = x + gain.8(1 - d) * curliness * vnoise(x); s = noise(freq * project(x'));
// f = gain.9(bias.3(s)) * d, with the remap 0.5 + 0.5 noise that it implies; exactly so where tribble_contrast is 1.
// Geometry-dependent.
// density: D in [0, 1]; result in [0, 1].
// @needs normal
// @groom length density direction
// @outer tribble_length
// @param tribble_length = 0.4 in [0.005, 0.8]: Length of the hair, object units: the width of the soft region.
// @param tribble_fineness = 24 in [2, 200]: Hairs per object unit.
// @param tribble_curliness = 0.3 in [0, 2]: How far the tip of a hair is moved, object units.
// @param curl_frequency = 4 in [0.2, 40]: Curls per object unit.
// @param tribble_contrast = 1.667 in [1, 2]: How strongly the noise tells hair from gap; 1 is PH's.
#include "vector_noise.glsl"
#include <wind>
#include "shaping.glsl"
#include <project>

// Where the matter that is now at a point grew.
vec3 uncurled(inout Sample s) {
    float tip = clamp(1.0 - s.density, 0.0, 1.0);
    mat3 slope;
    vec3 curl = tribble_curliness * vector_noise_slope(curl_frequency * s.x, slope);
    float strength = gain(0.8, tip);
    float growth = (gain(0.8, tip + 0.05) - gain(0.8, tip - 0.05)) / (0.1 * tribble_length);
    // A hair is where x' moves along the normal: (1 + derivative of the curl) tangent = normal, to first order.
    vec3 bend = growth * curl + strength * tribble_curliness * curl_frequency * (slope * s.normal);
    s.hair_normal = s.normal;
    groomed(bend -= 2.0 * tip * groom_direction(s.root);)
    windy(bend -= 2.0 * tip * wind(s.x);)
    s.hair_tangent = safe_normalize(s.normal - bend, s.normal);
    return s.x + strength * curl groomed(- tribble_length * tip * tip * groom_direction(s.root))
        windy(- tribble_length * tip * tip * wind(s.x));
}

float tribble(float density, inout Sample s) {
    s.hair_length = tribble_length;
    if (s.density >= 1.0) return density;
    vec3 root = project(uncurled(s), s);
    groomed(s.root = root; s.hair_length *= clamp(groom_length(root), 0.1, 1.0); density = groom_depth(density, root);)
    float strand = gain(0.9, bias(0.3, 0.5 + 0.5 * tribble_contrast * noise(tribble_fineness * root)
        groomed(+ 0.5 * (groom_density(root) - 1.0))));
    return strand * density * trust(s);
}
