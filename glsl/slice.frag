#version 450
// One fragment of one proxy slice: rejected, or a premultiplied color for the Over operator.
// Source: MJ 3.5 and 3.6.
// Slot <sampling> declares position_eye (eye space), x (object space) and color (linear RGBA of the vertex).
#include "interface.glsl"
#include "vector.glsl"
#include <sampling>
layout(location = 0) out vec4 fragment;
#include <projection>
#include <clip>
#include <classify>

void main() {
    if (clipped(x)) discard;
    vec4 matter = classify(x, step_size * path_scale());
    if (matter.a <= 0.0) discard;       // MJ 3.5: other fragments are rejected
    fragment = matter;                  // MJ 3.6: blended by the Over operator
}
