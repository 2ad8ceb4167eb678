// View-aligned slices.
// Source: MJ 2, 3.3.
// position: eye space; result: how deep the slice through it lies.
float plane_depth(vec3 position) { return -position.z; }
