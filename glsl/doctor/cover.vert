#version 450
// Triangles that each cover the whole target: as many layers as there are triples of vertices.
// Source: -
// Self-tests of `hypertexture doctor`.
void main() {
    int corner = gl_VertexIndex % 3;
    gl_Position = vec4(4.0 * float(corner & 1) - 1.0, 4.0 * float(corner >> 1) - 1.0, 0.0, 1.0);
}
