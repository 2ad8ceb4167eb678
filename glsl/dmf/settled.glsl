// Matter only where the object faces up, as snow or moss settles.
// Source: PH 2 (geometry-dependent DMF: it knows the gradient of the density), a reconstruction.
// density: any; result: the density times a factor in [0, 1]; the hard region keeps its own.
// @needs normal
// @param settle_slope = 0.5 in [-1, 1]: Vertical part of the normal from which on matter lies: 1 on level ground only.
// @param settle_width = 0.3 in [0.01, 2]: How gradually it ends, in the same measure.
float settled(float density, Sample s) {
    if (s.density >= 1.0) return density;
    return density * smoothstep(settle_slope - settle_width, settle_slope + settle_width, s.normal.y);
}
