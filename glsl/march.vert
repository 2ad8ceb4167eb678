#version 450
// One triangle that covers the picture.
// Source: -
// Vertices 0 to 2; no inputs.
void main() {
    vec2 corner = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(2.0 * corner - 1.0, 0.5, 1.0);
}
