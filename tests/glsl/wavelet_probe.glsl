// Wavelet noise over a plane, and its gradient at lattice points.
// Source: PH 2.3, footnote.
// Result: 0.5 + 0.5 noise at 4 x, length of the gradient at a lattice point, of that in the middle of its cell.
#include <noise>
vec3 surface(Sample s) {
    s.x.z = 0.37;
    vec3 cell = floor(8.0 * s.x);
    return vec3(0.5 + 0.5 * noise(4.0 * s.x), length(noise_gradient(cell).xyz), length(noise_gradient(cell + 0.5).xyz));
}
