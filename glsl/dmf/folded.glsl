// The density folded over at a value: it falls to 0 there and rises again below, as a bubble around a core.
// Source: PH 2.3 (abs as a base function); position-independent: f(k).
// density: held in [0, 1]; result in [0, 1]: 1 stays 1, and the outer border of the soft region becomes a shell.
// @param fold = 0.4 in [0, 0.95]: Density that becomes 0.
float folded(float density, Sample s) { return abs(clamp(density, 0.0, 1.0) - fold) / (1.0 - fold); }
