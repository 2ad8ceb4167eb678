// One sample per pixel: what comes from the vertices is taken at its center.
// Source: -
// position_eye_in: eye space; color_in: linear RGBA of the vertex.
layout(location = 0) in vec3 position_eye_in;
layout(location = 2) in vec4 color_in;
#include "on_ray.glsl"
