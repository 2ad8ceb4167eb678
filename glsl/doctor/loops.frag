#version 450
// How far a loop runs: the state of a generator tells its steps, and no compiler knows it in closed form.
// Source: Numerical Recipes' linear congruential generator.
// Result: the low and the high 16 bits of the state after 70000 steps from 0.
layout(location = 0) out vec4 fragment;
void main() {
    uint state = uint(gl_FragCoord.x);      // 0 in the first pixel, and unknown to the compiler
    for (int step = 0; step < 70000; ++step) state = state * 1664525u + 1013904223u;
    fragment = vec4(float(state & 65535u), float(state >> 16u), 0.0, 1.0);
}
