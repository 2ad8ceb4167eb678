// Perlin's noise of 1989 with its tables in images of one row.
// Source: MJ 4.2: "around 10 texture fetches" for a noise; here 11: an entry of the permutation comes with the next one,
// and the gradients are stored in the order in which the permutation points to them.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 0.867. The lattice repeats after 256 cells,
// as the sampler repeats the images; fetches are at texel centers, where no filter mixes.
#include "corners.glsl"
vec2 permuted(float index) { return textureLod(permutation_table, (index + 0.5) / 256.0, 0.0).rg; }
vec3 table_knot(float index) { return textureLod(gradient_table, (index + 0.5) / 256.0, 0.0).rgb; }

vec4 table_noise(vec3 p) {
    vec3 inside = clamp(p, vec3(-1048576.0), vec3(1048576.0)), base = floor(inside);
    vec3 cell = base - 256.0 * floor(base / 256.0);
    vec2 k = permuted(cell.z);
    vec2 a = permuted(cell.y + k.x), b = permuted(cell.y + k.y);
    return noise_of_corners(inside - base,
                            table_knot(cell.x + a.x), table_knot(cell.x + 1.0 + a.x),
                            table_knot(cell.x + a.y), table_knot(cell.x + 1.0 + a.y),
                            table_knot(cell.x + b.x), table_knot(cell.x + 1.0 + b.x),
                            table_knot(cell.x + b.y), table_knot(cell.x + 1.0 + b.y));
}
