// Noise of a lattice with period setting.z + 1 along the oblique line (t, t / 2 + setting.w, t / 4 + setting.w).
// Result: noise; noise evaluated with its gradient; slope along x; t.
#include "lattice_noise.glsl"
void main() {
    float t = place();
    vec3 p = vec3(t, 0.5 * t, 0.25 * t) + vec3(0.0, setting.w, setting.w);
    vec4 n = lattice_noise_gradient(p, uint(setting.z));
    fragment = vec4(lattice_noise(p, uint(setting.z)), n.w, n.x, t);
}
