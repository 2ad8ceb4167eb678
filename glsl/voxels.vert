#version 450
// Rectangles of pixels, each with the voxels of a cube: see voxels.frag.
// Source: -
// corner: clip space, and the first pixel of the rectangle; first: voxel, object space, and voxels along a side; along_x, y,
// z: steps between voxels, object space.
layout(location = 0) in vec4 corner;
layout(location = 1) in vec4 first;
layout(location = 2) in vec3 along_x;
layout(location = 3) in vec3 along_y;
layout(location = 4) in vec3 along_z;
layout(location = 0) flat out vec4 first_out;
layout(location = 1) flat out vec2 pixel_out;
layout(location = 2) flat out mat3 along_out;
void main() {
    first_out = first;
    pixel_out = corner.zw;
    along_out = mat3(along_x, along_y, along_z);
    gl_Position = vec4(corner.xy, 0.5, 1.0);
}
