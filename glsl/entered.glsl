// Where a ray enters soft matter so dense that it hides what is behind it: there it is shaded, since deeper in its
// density may have no gradient.
// Source: ours: bisection of the step between the sample before and this one.
// s: a sample; density: modulated, in [0, 1]; then both where it has half of it, or where a plane cut it; path: of the
// step, object units. What is shaded is lit where it is.
#include "modulated.glsl"
const int BISECTIONS = 4;

void enter(inout Sample s, inout float density, float path) {
#ifndef ONE_SAMPLE
    if (opacity(density, opacity_rate * path) < 0.5) return;
    vec3 back = mat3(texture_matrix) * (to_eye() * path), x = s.x;
    float half_density = 0.5 * density, end = kept(x, back).y, inside = 0.0, outside = end;
    if (modulated_density(x + end * back) >= half_density) {
        if (end >= 1.0) return;
        inside = end;                           // where it is cut open
    }
    for (int halving = 0; halving < BISECTIONS; ++halving) {
        float middle = 0.5 * (inside + outside);
        if (modulated_density(x + middle * back) >= half_density) inside = middle;
        else outside = middle;
    }
    s = sample_object(x + inside * back);
    density = s.density > 0.0 ? clamp(modulate(s.density, s), 0.0, 1.0) : 0.0;
    position_eye += to_eye() * (inside * path);
#endif
}
