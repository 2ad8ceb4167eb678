#version 450
// Texels of the shadow volume: see shadow.glsl.
// Source: PH 4 and MJ 7.
// Result: transmittances in [0, 1].
#include "interface.glsl"
#include "vector.glsl"
layout(location = 0) out vec4 fragment;
#include "shadow.glsl"

void main() { cast_light(); }
