// Wax, jade, clouds: soft matter that scatters the light that reaches it to all sides alike.
// Source: GG 39.5.1; Kniss et al. 2003 (a constant phase function).
// density: modulated, in [0, 1]; result: linear RGB. Without shadows, half of the light reaches it.
#include <shadow>
vec3 medium(Sample s, float density) {
    return color.rgb * material_color.rgb * (ambient_color.rgb + shadow(0.5, vec3(0.0)) * light_color.rgb);
}
