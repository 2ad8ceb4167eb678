#version 450
// A uniform that is first read in a loop, which pixels leave after different turns, and again behind it.
// Source: docs/notes/drivers.md, Mesa 26.1.
// Result: three times the setting. The derivative has the program run in pixels that the triangle does not cover, too.
layout(set = 0, binding = 0) uniform Setting { vec4 setting; };
layout(location = 0) out vec4 fragment;
void main() {
    int turns = (int(gl_FragCoord.x) + 3 * int(gl_FragCoord.y)) % 7, turn = 0;
    float sum = 0.0;
    for (;;) {
        ++turn;
        if (turn < turns) continue;
        sum += setting.x;
        if (sum > 0.5 || turn > 99) break;
    }
    fragment = vec4(3.0 * setting.x, dFdx(gl_FragCoord.x), sum, 1.0);
}
