// Fur: noise, constant along the direction of growth, sharpened into hairs that thin out towards their tips.
// Source: PH 2.4: f = gain.9(bias.3(noise(frequency * project(x)))) * D(x), with the remap 0.5 + 0.5 noise it implies;
// curl is the tribble's; droop, uneven length and the middle of a hair in place of its root are ours. PH's own form has
// curliness, droop, unevenness and hair_middle 0, and hair_contrast 1.
// density: D in [0, 1]; result in [0, 1].
// @needs normal
// @groom length density direction
// @outer hair_length
// @param hair_length = 0.2 in [0.005, 0.8]: Length of the hair, object units: the width of the soft region.
// @param fineness = 40 in [2, 200]: Hairs per object unit.
// @param curliness = 0.04 in [0, 0.5]: Sideways wave of the hair, object units at the tip.
// @param droop = 0.45 in [0, 2]: How far gravity bends the tip, in hair lengths.
// @param unevenness = 0.5 in [0, 1]: Spread of the length from hair to hair.
// @param hair_bias = 0.3 in [0.01, 0.99]: Thickness of the hair: PH's bias.
// @param hair_gain = 0.9 in [0.01, 0.99]: Sharpness of its edge: PH's gain.
// @param hair_contrast = 1.667 in [1, 2]: How strongly the noise tells hair from gap; 1 is PH's.
// @param hair_middle = 0.5 in [0, 1]: Where on a hair its noise is taken: 0 is its root, as PH do, 1 its tip.
#include <noise>
#include <wind>
#include <project>
#include "shaping.glsl"

// The place where a hair would be without droop and curl.
vec3 unbent(Sample s, float tip) {
    vec3 curl = noise_gradient(3.0 * s.x + 17.0).xyz * (0.5 * curliness * gain(0.8, tip));
    return s.x + vec3(0.0, droop * hair_length * tip * tip, 0.0) + curl
        groomed(- hair_length * tip * tip * groom_direction(s.root)) windy(- hair_length * tip * tip * wind(s.x));
}

float fur(float density, inout Sample s) {
    s.hair_length = hair_length;
    if (density >= 1.0) return 1.0;
    vec3 straight = unbent(s, 1.0 - density);
    vec3 root = project(straight, s);
    s.hair_normal = safe_normalize(straight - root, s.normal);
    float tip = clamp(1.0 - s.density, 0.0, 1.0);
    s.hair_tangent = safe_normalize(s.hair_normal - vec3(0.0, 2.0 * droop * tip, 0.0)
        groomed(+ 2.0 * tip * groom_direction(s.root)) windy(+ 2.0 * tip * wind(s.x)), s.hair_normal);
    groomed(s.root = root; s.hair_length *= clamp(groom_length(root), 0.1, 1.0);)
    // A hair is known by its middle, not by its root: all of the space around an edge or a speck has one root.
    vec3 middle = root + hair_middle * hair_length * s.hair_normal;
    float shorter = unevenness * clamp(0.5 + noise(0.23 * fineness * middle), 0.0, 1.0);
    groomed(shorter = clamp(1.0 - groom_length(root) * (1.0 - shorter), 0.0, 0.999);)
    float grown = max((density - shorter) / (1.0 - shorter), 0.0);
    if (grown <= 0.0) return 0.0;               // the hair ends before
    float strand = gain(hair_gain, bias(hair_bias, 0.5 + 0.5 * hair_contrast * noise(fineness * middle)
        groomed(+ 0.5 * (groom_density(root) - 1.0))));
    return strand * grown * trust(s);
}
