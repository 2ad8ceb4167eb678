// A homogeneous slab between z = 1/4 and z = -1/4.
// Source: -
// density: ignored; result 0 or 1.
float pane(float density, Sample s) { return abs(s.x.z) < 0.25 ? 1.0 : 0.0; }
