#version 450
// Places the vertices of the proxy slices; the geometry comes from slot <proxy>.
// Source: MJ 3.3 and 3.4.
// The slices stay where they are in eye space; only texture_matrix turns.
#include "interface.glsl"
layout(location = 0) out vec3 position_eye_out;
layout(location = 1) out vec3 x_out;
layout(location = 2) out vec4 color_out;
#include <proxy>

void main() {
    vec3 position_eye = proxy_position();
    position_eye_out = position_eye;
    x_out = (texture_matrix * vec4(proxy_tex_coord(), 1.0)).xyz;             // MJ 3.4: texture coordinates turn
    color_out = proxy_color();
    gl_Position = projection * (display_matrix * vec4(position_eye, 1.0));   // MJ 3.4: fixed ModelViewProjection
}
