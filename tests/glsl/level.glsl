// A given density, for tests of what is done with densities.
// density: ignored; result in [0, 1].
// @param amount = 0.5 in [0, 1]: The density.
float level(float density, Sample s) { return density > 0.0 ? amount : 0.0; }
