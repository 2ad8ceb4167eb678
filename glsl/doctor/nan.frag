#version 450
// Which NaN survive the compilers: 0 / 0, inf - inf and NaN * 0, each told by its bits.
// Source: -
// Result: 1 for each that is NaN, in red, green and blue.
layout(location = 0) out vec4 fragment;
float is_nan(float value) { return (floatBitsToUint(value) & 0x7fffffffu) > 0x7f800000u ? 1.0 : 0.0; }
void main() {
    float zero = gl_FragCoord.x - 0.5;      // 0 in the first pixel, and unknown to the compiler
    float infinity = 1.0 / zero;
    float nan = uintBitsToFloat(0x7fc00000u + uint(zero));
    fragment = vec4(is_nan(0.0 / zero), is_nan(infinity - infinity), is_nan(nan * 0.0), 1.0);
}
