// The direction in which the modulated density falls fastest: the normal of hypertexture.
// Source: PH 3.1 (the gradient of the density, from differences).
// s: sample; density: modulated, there; step: object units; result: unit, object space.
vec3 density_normal(Sample s, float density, float step) {
    float kept = clearance;                                     // these samples are none of the ray's
    vec3 slope;
    for (int axis = 0; axis < 3; ++axis) {
        vec3 x = s.x;
        x[axis] += step;
        Sample beside = sample_object(x);
        slope[axis] = density - clamp(modulate(beside.density, beside), 0.0, 1.0);
    }
    clearance = kept;
    return safe_normalize(slope, s.normal);
}
