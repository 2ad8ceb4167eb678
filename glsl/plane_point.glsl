// A plane through the noise, parallel to x and y: what debug looks show, whatever the object.
// Source: MJ 4.1, Fig. 5.
// Object space; result: lattice cells.
// @param plane_z = 0.06 in [-4, 4]: z of the plane of noise that is shown, object units.
// @param plane_frequency = 8 in [0.5, 64]: Noise cells per object unit.
vec3 plane_point(Sample s) { return plane_frequency * vec3(s.x.xy, plane_z); }
