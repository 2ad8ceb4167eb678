#version 450
// The opacity of a path, for an entry of a table. Evaluated, never drawn.
// Source: PH 3.1.
// given: density, and the rate times the path; result: opacity in x.
#include "interface.glsl"
layout(location = 0) in vec4 given;
layout(location = 0) out vec4 result;
#include <opacity>

void main() { result = vec4(opacity(given.x, given.y)); }
