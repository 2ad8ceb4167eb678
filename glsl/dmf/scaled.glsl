// The density times a factor, plus a number.
// Source: PH 2.3 (arithmetic as a base function); position-independent: f(k).
// density: any; result: any.
// @param density_factor = 1 in [-10, 10]: Factor.
// @param density_offset = 0 in [-10, 10]: What is added.
float scaled(float density, Sample s) { return density_factor * density + density_offset; }
