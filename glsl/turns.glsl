// Angles and waves by polynomials, which every device rounds alike: Vulkan leaves atan an error of 4096 ulp, and sin and cos
// one of 2^-11, without a limit beyond half a turn.
// Source: fits of least maximal error, each coefficient rounded to f32 before the next is fitted.

// The angle of a vector from the x axis, turns in [-0.5, 0.5]; the error is at most 2e-9, and f32's rounding.
float turns_of(vec2 v) {
    vec2 a = abs(v);
    float t = min(a.x, a.y) / max(max(a.x, a.y), 1e-30), q = t * t;
    float turns = t * (0.159154922 + q * (-0.0530502982 + q * (0.0318057798 + q * (-0.0225190576 + q * (0.0166397411 +
                  q * (-0.0113720549 + q * (0.00616685674 + q * (-0.00219194358 + q * 0.000366053864))))))));
    turns = a.y > a.x ? 0.25 - turns : turns;
    turns = v.x < 0.0 ? 0.5 - turns : turns;
    return v.y < 0.0 ? -turns : turns;
}

// sin(pi part) for parts in [0, 1]; the error is at most 2e-9, and f32's rounding.
float half_wave(float part) {
    float z = (part - 0.5) * (part - 0.5);
    return 1.0 + z * (-4.93480206 + z * (4.05870533 + z * (-1.33516157 + z * (0.234683722 - z * 0.0239636544))));
}
