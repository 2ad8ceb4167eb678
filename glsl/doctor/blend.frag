#version 450
// One of 1024 layers of a homogeneous medium of optical depth 2.
// Source: 1 - exp(-2 / 1024).
// Result: premultiplied white.
layout(location = 0) out vec4 fragment;
void main() { fragment = vec4(0.0019512189); }
