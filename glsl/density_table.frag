#version 450
// The density at a distance, for an entry of a table. Evaluated, never drawn.
// Source: MJ 6.
// given: distance, object units; result: density in x.
#include "interface.glsl"
layout(location = 0) in vec4 given;
layout(location = 0) out vec4 result;
#include <softness>

void main() { result = vec4(soften(given.x)); }
