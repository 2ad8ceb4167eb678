// Soft matter in the bare material color.
// Source: MJ 6.
// density: modulated, in [0, 1]; result: linear RGB.
vec3 medium(Sample s, float density) { return color.rgb * material_color.rgb; }
