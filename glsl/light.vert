#version 450
// One triangle that covers the buffer of the light, for each slice.
// Source: -
// corner: x and y in clip space; z: how deep the slice lies, eye space.
layout(location = 0) in vec3 corner;
layout(location = 0) flat out float depth_out;
void main() {
    depth_out = corner.z;
    gl_Position = vec4(corner.xy, 0.5, 1.0);
}
