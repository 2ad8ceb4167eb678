// A hypertextured object: the surface in the hard region, the modulated density around it.
// Source: MJ 6; the opacity is PH 3.1, and so is that a gradient is asked for only where 0 < density < 1.
// x: object space; path: object units; result premultiplied linear RGBA.
#include "sample.glsl"
#include <dmf>
#include <opacity>
#include <gradient>
#include <surface>
#include <medium>

vec4 classify(vec3 x, float path) {
    Sample s = sample_object(x);
    float density = s.density > 0.0 ? clamp(modulate(s.density, s), 0.0, 1.0) : 0.0;
    if (density <= 0.0) {                                   // MJ 6: outside the soft region
        remember(0.0);
        return vec4(0.0);
    }
    if (s.density >= 1.0) s.normal = cap_normal(x, s.normal);
    else if (density < 1.0) s.shading = shading_normal(s, density, path);
    remember(density);
    vec3 shade = s.density >= 1.0 ? surface(s) : medium(s, density);
    float alpha = opacity(density, opacity_rate * path);
    return vec4(shade * alpha, alpha);
}
