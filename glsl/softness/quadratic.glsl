// A soft region between two radii, density linear in the squared radius.
// Source: MJ Eq. 1, PH 2.1, factored: (ro - r)(ro + r) does not cancel; radii are held at 0 or more.
// distance: to the unit sphere or, for another object, to its surface at that reference radius; result in [0, 1].
// Unclamped: the same parabola beyond both radii.
const float REFERENCE_RADIUS = 1.0;

// outer: where the soft region starts; without it, at the outer iso-value.
float soften(float distance, float outer) {
    float r = max(REFERENCE_RADIUS + distance, 0.0);
    float r_outer = max(REFERENCE_RADIUS + outer, 0.0);
    float r_inner = max(REFERENCE_RADIUS + iso_value, 0.0);
    float width = (r_outer - r_inner) * (r_outer + r_inner);
    float soft = clamp((r_outer - r) * (r_outer + r) / width, 0.0, 1.0);
    return mix(float(distance <= iso_value), soft, width > 0.0);
}
float soften(float distance) { return soften(distance, outer_iso_value); }
float soften_unclamped(float distance) {
    float r = max(REFERENCE_RADIUS + distance, 0.0);
    float r_outer = max(REFERENCE_RADIUS + outer_iso_value, 0.0);
    float r_inner = max(REFERENCE_RADIUS + iso_value, 0.0);
    float width = max((r_outer - r_inner) * (r_outer + r_inner), 1e-6);
    return 1.0 + (r_inner - r) * (r_inner + r) / width;
}
