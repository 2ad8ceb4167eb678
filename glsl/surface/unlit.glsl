// The bare material color.
// Source: MJ 5.1 (left unlit).
// Result: linear RGB.
vec3 surface(Sample s) { return color.rgb * material_color.rgb; }
