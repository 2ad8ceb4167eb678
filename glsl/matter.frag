#version 450
// Matter at a point. Evaluated, never drawn.
// Source: -
// place: object space. Result: as in matter.glsl.
#include "interface.glsl"
#include "vector.glsl"
layout(location = 0) in vec4 place;
layout(location = 0) out vec4 fragment;
#include "matter.glsl"

void main() { fragment = matter_at_point(place.xyz); }
