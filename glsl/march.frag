#version 450
// One ray through the picture: matter is composited front to back until the ray ends.
// Source: PH 3.1; MJ 7 (fragment shader loops): see march.glsl.
// Result: premultiplied linear RGBA.
#include "interface.glsl"
#include "vector.glsl"
#include "trace.glsl"
vec3 position_eye;                      // eye space
#define MEETS(matter, k) sum += (1.0 - sum.a) * (matter)        // PH 3.1: front to back
#define ENDS sum.a >= full_opacity                              // PH 3.1: until opaque
#define GIVES sum
#include "march.glsl"
