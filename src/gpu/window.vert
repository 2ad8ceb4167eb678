#version 450
// A vertex of the window: its place from -1 to 1, its place in a texture, and its color.
layout(location = 0) in vec2 place;
layout(location = 1) in vec2 texel;
layout(location = 2) in vec4 tint;
layout(location = 0) out vec2 texel_of_fragment;
layout(location = 1) out vec4 tint_of_fragment;

void main() {
    gl_Position = vec4(place, 0.0, 1.0);
    texel_of_fragment = texel;
    tint_of_fragment = tint;
}
