// One object of a scene that has several: its sample, its modulated density, and its color.
// Source: MJ 7 (complex volumetric scenes), PH 2.2.
// x and normal: object space of the scene; the sample lives in the space of the object, which place_matrix leads to.
#include "sample.glsl"
#include "soft.glsl"
#include <dmf>
#include <surface>
#include <medium>

Sample one_sample(vec3 x) { return sample_object((place_matrix * vec4(x, 1.0)).xyz); }

float one_density(inout Sample s) { return s.density > 0.0 ? clamp(modulate(s.density, s), 0.0, 1.0) : 0.0; }

Soft one_soft(Sample s, float density) {
    vec3 normal = place_scale * (transpose(mat3(place_matrix)) * s.normal);
    float width = place_scale * (outer_iso_value - iso_value);
    bool sloped = s.density > 0.0 && s.density < 1.0 && width > 0.0;
    return Soft(density, sloped ? normal / -width : vec3(0.0), place_scale * (s.distance - iso_value), normal,
                place_scale * s.distance_bound);
}

vec3 one_shade(Sample s, float density, vec3 normal) {
    s.normal = place_scale * (mat3(place_matrix) * normal);
    s.shading = s.normal;
    return s.density >= 1.0 ? surface(s) : medium(s, density);
}
