// Bias and gain: the shaping functions of hypertexture.
// Source: PH 2.3, MJ Eq. 5 and 6.
// t is held in [0, 1]; b and g in [2^-10, 1 - 2^-10]; results in [0, 1], exact at 0 and 1 (gain also at 1/2).
float bias(float b, float t) {
    if (t <= 0.0) return 0.0;
    if (t >= 1.0) return 1.0;
    return pow(t, log(clamp(b, 0.0009765625, 0.9990234375)) / log(0.5));
}

float gain(float g, float t) {
    float half_of = 0.5 * bias(1.0 - g, t < 0.5 ? 2.0 * t : 2.0 - 2.0 * t);
    return t < 0.5 ? half_of : 1.0 - half_of;
}
