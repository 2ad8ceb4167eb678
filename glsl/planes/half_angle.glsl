// Slices that face half way between the eye and the light, or the eye's other side where the light is behind the object:
// both look through them in one order.
// Source: GG 39.5.1; Kniss et al. 2003.
// position: eye space; result: how deep the slice through it lies, away from the light.
float plane_depth(vec3 position) { return -dot(slice_axis.xyz, position); }
