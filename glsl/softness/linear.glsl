// A soft region between two iso-values, density linear in the distance.
// Source: MJ 6 (two iso-values); the paper prints no formula: a reconstruction.
// distance: object units, positive outside; result in [0, 1]. Unclamped: the same line beyond both iso-values.
// outer: where the soft region starts; without it, at the outer iso-value.
float soften(float distance, float outer) {
    float width = outer - iso_value;
    return mix(float(distance <= iso_value), clamp((outer - distance) / width, 0.0, 1.0), width > 0.0);
}
float soften(float distance) { return soften(distance, outer_iso_value); }
float soften_unclamped(float distance) {
    return 1.0 + (iso_value - distance) / max(outer_iso_value - iso_value, 1e-6);
}
