// Several samples per pixel: what comes from the vertices is taken at each sample. Without `sample`, Vulkan lets a
// driver take it once per pixel, and an edge that lies in the matter, not in the geometry, stays jagged.
// Source: MJ 7 (sampling 4x and 8x); Vulkan 1.3, Interpolation Decorations.
// position_eye_in: eye space; color_in: linear RGBA of the vertex.
layout(location = 0) sample in vec3 position_eye_in;
layout(location = 2) sample in vec4 color_in;
#include "on_ray.glsl"
