// A stack of slices that is looked at from the side: no ray of the picture goes where the slices were sampled, and what
// comes from the vertices is taken, at each sample of a pixel.
// Source: MJ Fig. 1, 3.5.
// position_eye_in: eye space; x_in: object space; color_in: linear RGBA of the vertex.
layout(location = 0) sample in vec3 position_eye_in;
layout(location = 1) sample in vec3 x_in;
layout(location = 2) sample in vec4 color_in;
void place(out vec3 eye, out vec3 x) {
    eye = position_eye_in;
    x = x_in;
}
