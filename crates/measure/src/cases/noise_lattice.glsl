// Noise at lattice points, and between them.
// Source: -
// Result: |noise| at a lattice point, at a point between, 0.
#include <noise>
vec3 surface(Sample s) {
    vec3 p = 40.0 * vec3(s.x.xy, s.x.x * s.x.y);
    return vec3(abs(noise(floor(p))), abs(noise(p)), 0.0);
}
