// Perlin's noise of 1989 with its tables in constant arrays.
// Source: PH 2.3: G[phi(i + phi(j + phi(k)))]; MJ 4.2: impossible in a fragment shader of 2005, which could not index them.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 0.867. The lattice repeats after 256 cells.
#include "corners.glsl"
#include "noise_tables.glsl"
vec3 array_knot(int i, int plane) { return GRADIENTS[PERMUTATION[(i + plane) & 255]]; }

vec4 array_noise(vec3 p) {
    vec3 inside = clamp(p, vec3(-1048576.0), vec3(1048576.0)), base = floor(inside);
    ivec3 cell = ivec3(base);
    int k0 = PERMUTATION[cell.z & 255], k1 = PERMUTATION[(cell.z + 1) & 255];
    int a = PERMUTATION[(cell.y + k0) & 255], b = PERMUTATION[(cell.y + 1 + k0) & 255];
    int c = PERMUTATION[(cell.y + k1) & 255], d = PERMUTATION[(cell.y + 1 + k1) & 255];
    return noise_of_corners(inside - base,
                            array_knot(cell.x, a), array_knot(cell.x + 1, a), array_knot(cell.x, b), array_knot(cell.x + 1, b),
                            array_knot(cell.x, c), array_knot(cell.x + 1, c), array_knot(cell.x, d), array_knot(cell.x + 1, d));
}
