// log(1 - d) and exp(x) - 1 without cancellation for small arguments.
// Source: series of atanh and exp; the direct forms lose every digit of a thin medium in f32.
// d in [0, 1); t <= 0.
float log_one_minus(float d) {
    precise float q = d / (2.0 - d);
    precise float q2 = q * q;
    precise float series =
        -2.0 * q * (1.0 + q2 * (1.0 / 3.0 + q2 * (1.0 / 5.0 + q2 * (1.0 / 7.0 + q2 * (1.0 / 9.0 + q2 / 11.0)))));
    return d < 0.3 ? series : log(1.0 - d);
}

// Below -0.35 the direct form is exact enough; above it the series of degree 7 is.
float exp_minus_one(float t) {
    precise float series =
        t * (1.0 + t / 2.0 * (1.0 + t / 3.0 * (1.0 + t / 4.0 * (1.0 + t / 5.0 * (1.0 + t / 6.0 * (1.0 + t / 7.0))))));
    return t > -0.35 ? series : exp(max(t, -88.0)) - 1.0;
}
