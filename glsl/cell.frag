#version 450
#define ONE_SAMPLE
// Whether there is matter at a place: its opacity. Evaluated over boxes, never drawn.
// Source: ours; as PH 3.1 has it, space is empty where the density is not above 0.
// place: object space. Result: of a path so long that thin matter is seen; what counts is whether its alpha is above 0.
#include "interface.glsl"
#include "vector.glsl"
layout(location = 0) in vec4 place;
layout(location = 0) out vec4 fragment;
vec3 position_eye;                      // eye space
const bool follows = false;             // no sample was taken before
vec4 color = vec4(1.0);
#include <projection>
#include <clip>
#include <classify>

void main() {
    position_eye = (object_matrix * vec4(place.xyz, 1.0)).xyz;
    fragment = classify(place.xyz, step_size);
}
