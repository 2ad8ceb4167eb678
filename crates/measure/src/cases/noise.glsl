// Noise of a lattice that repeats after setting.z + 1 cells, along a line that no axis has: at (t, t / 2, t / 4) and, in
// the other directions, setting.w from there.
// Result: noise; noise with its gradient: noise, its slope along x; the place t.
#include "lattice_noise.glsl"
void main() {
    float t = place();
    vec3 p = vec3(t, 0.5 * t, 0.25 * t) + vec3(0.0, setting.w, setting.w);
    vec4 n = lattice_noise_gradient(p, uint(setting.z));
    fragment = vec4(lattice_noise(p, uint(setting.z)), n.w, n.x, t);
}
