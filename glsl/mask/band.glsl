// Where a DMF acts: a band of the depth in the soft region.
// Source: MJ 6: different DMFs through the soft region, possible and not done in the paper.
// Result in [0, 1]; the density of the object, before any DMF, is the depth: 0 outside, 1 at the hard region.
// @param band_from = 0.0 in [0, 1]: Depth at which the band begins: 0 is the outside.
// @param band_to = 0.5 in [0, 1]: Depth at which the band ends: 1 is the hard region.
// @param band_blend = 0.1 in [0.001, 1]: Width over which it fades.
float band(Sample s) {
    float half_blend = 0.5 * band_blend;
    return smoothstep(band_from - half_blend, band_from + half_blend, s.density)
         * (1.0 - smoothstep(band_to - half_blend, band_to + half_blend, s.density));
}
