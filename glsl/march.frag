#version 450
// One ray through the picture, composited front to back.
// Source: PH 3.1; MJ 7 (fragment shader loops): see march.glsl.
// Result: premultiplied linear RGBA.
#include "interface.glsl"
#include "vector.glsl"
layout(location = 0) out vec4 fragment;
#include "ray.glsl"

void main() { march(); }
