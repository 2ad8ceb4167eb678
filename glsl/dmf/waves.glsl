// A sine of the density: shells around the object, like the rings of an onion.
// Source: PH 2.3 (sine as a base function); position-independent: f(k).
// density: any; result: the density times a factor in [1 - wave_depth, 1]; 1 stays 1.
// @param wave_count = 4 in [1, 40]: Shells across the soft region.
// @param wave_depth = 1 in [0, 1]: How empty it is between the shells.
float waves(float density, Sample s) {
    return density * (1.0 - wave_depth * (0.5 - 0.5 * cos(6.2831853 * floor(wave_count) * density)));
}
