#version 450
// Matter at the voxels of a cube: x and z across a rectangle of pixels, y down it.
// Source: -
// Result: as in matter.glsl.
#include "interface.glsl"
#include "vector.glsl"
layout(location = 0) flat in vec4 first;    // object space; voxels along a side
layout(location = 1) flat in vec2 pixel;    // of the first voxel
layout(location = 2) flat in mat3 along;    // steps between voxels, object space
layout(location = 0) out vec4 fragment;
#include "matter.glsl"

void main() {
    vec2 at = floor(gl_FragCoord.xy) - pixel;
    float z = floor((at.x + 0.5) / first.w);
    fragment = matter_at_point(first.xyz + along * vec3(at.x - z * first.w, at.y, z));
}
