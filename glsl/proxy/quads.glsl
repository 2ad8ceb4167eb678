// One static quad per slice, large enough for every rotation: the paper's geometry.
// Source: MJ 2, 3.3, 3.4 and Fig. 1; GG 39.6.1 on its cost.
// position: eye space; tex_coord: object space before the trackball turns it; material: tint of the slice, linear RGBA.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 tex_coord;
layout(location = 2) in vec4 material;

vec3 proxy_position() { return position; }
vec3 proxy_tex_coord() { return tex_coord; }
vec4 proxy_color() { return material; }
