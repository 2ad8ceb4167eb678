// Noise of an integer hash, as bounds of it know it: looked up as if there were an image of all its cells, whose level is
// its period. Never drawn.
// Source: ours; of crates/noise/src/range.rs.
// p, mask and results: as lattice_noise.glsl has them.
#include <wrap>
vec4 lattice_noise_gradient(vec3 p, uint mask) {
    float period = float(mask + 1u);
    vec4 n = textureLod(cell_grid, folded(p, period), period);
    return vec4(n.xyz * fold_sign(p, period), n.w);
}
float lattice_noise(vec3 p, uint mask) { return lattice_noise_gradient(p, mask).w; }
