// One sample per pixel: what comes from the vertices is taken at its center.
// Source: -
// position_eye: eye space; x: object space; color: linear RGBA of the vertex.
layout(location = 0) in vec3 position_eye;
layout(location = 1) in vec3 x;
layout(location = 2) in vec4 color;
