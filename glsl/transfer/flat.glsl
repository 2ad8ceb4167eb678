// A transfer map of one color and one opacity: what every texel of it holds.
// Source: as map.glsl.
// density: any; result: linear RGB, density in A.
vec4 transfer(float density) { return transfer_color; }
