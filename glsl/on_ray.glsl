// Where the ray of this pixel crosses the slice: the sample that a march takes. A rasterizer moves vertices to a 256th of a
// pixel, and what comes from them is off by as much.
// Source: ours; MJ 3.5 has the coordinates of the vertices, which they are but for that.
// eye: eye space; x: object space.
void place(out vec3 eye, out vec3 x) {
    vec2 ndc = gl_FragCoord.xy * picture_scale.xy - 1.0 + picture_scale.zw;
    float before = plane_depth(ray_at(ndc, 0.0)), along = plane_depth(ray_at(ndc, 1.0)) - before;
    eye = ray_at(ndc, (plane_depth(position_eye_in) - before) / along);
    x = (texture_matrix * vec4(eye, 1.0)).xyz;
}
