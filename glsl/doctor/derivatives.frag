#version 450
// Derivatives of a number of turns, which differs from pixel to pixel.
// Source: -
// Result: dFdx and dFdy, then the fine ones.
layout(location = 0) out vec4 fragment;
void main() {
    int turns = (5 * int(gl_FragCoord.x) + 3 * int(gl_FragCoord.y)) % 7;
    float value = 0.0;
    for (int turn = 0; turn < turns; ++turn) ++value;
    fragment = vec4(dFdx(value), dFdy(value), dFdxFine(value), dFdyFine(value));
}
