// Smoke and clouds: bright where the matter thins out towards the light, dark where it grows denser.
// Source: PH 1 promises clouds and smoke and prints no formula: a reconstruction, by one sample towards the light.
// density: modulated, in [0, 1]; result: linear RGB.
// @color vapor_color = #f4f2ee: Color in the light.
// @color shade_color = #6a7486: Color in the shade.
// @param shade_distance = 0.15 in [0.01, 1]: How far towards the light the matter is looked at, object units.
// @param shade_depth = 1.5 in [0, 10]: How dark the shade is.
// @places 1
vec3 medium(Sample s, float density) {
    vec3 towards = safe_normalize(mat3(texture_matrix) * (light_position.xyz - position_eye), vec3(0.0, 1.0, 0.0));
    Sample nearer = sample_object(s.x + shade_distance * towards);
    float blocking = nearer.density > 0.0 ? clamp(modulate(nearer.density, nearer), 0.0, 1.0) : 0.0;
    float light = clamp(0.75 + 0.5 * shade_depth * (density - blocking) - 0.5 * blocking, 0.0, 1.0);
    return mix(shade_color.rgb, vapor_color.rgb * light_color.rgb, light);
}
