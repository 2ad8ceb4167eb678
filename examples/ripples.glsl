// Ripples: rings of soft matter around the object.
// density: D in [0, 1], 1 in the object and 0 outside its soft region; result in [0, 1].
// @outer ring_width
// @param ring_width = 0.3 in [0.01, 1]: Width of the soft region, object units.
// @param rings = 6 in [1, 40]: Number of rings.
float ripples(float density, Sample s) {
    return density >= 1.0 ? 1.0 : density * (0.5 + 0.5 * cos(6.2831853 * rings * density));
}
