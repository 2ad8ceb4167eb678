// The space in which shadows are kept: rays from the light, by their place on a map of directions, and the distance along
// them.
// Source: ours; opacity by distance from the light is kept as by Lokovic and Veach 2000 (deep shadow maps).
// position: eye space; place: in [0, 1] across the scene, x and y the ray, z the distance from the light.
// A ray at an angle a from the axis of the light lies 4 sin(a / 4) from the middle of the map: nearly a, up to half a turn,
// since a light may be inside of the scene. Roots and quotients alone give it. Vulkan leaves sin, cos and atan errors that
// would move shadows from driver to driver (docs/notes/drivers.md).
vec3 to_light_space(vec3 position) {
    vec3 p = (shadow_matrix * vec4(position, 1.0)).xyz;
    float far = max(length(p), 1e-9);
    // Of half the angle: the greater one of sine and cosine by a root, the other one by it, so that neither cancels.
    float greater = sqrt(0.5 + 0.5 * min(abs(p.z) / far, 1.0));
    vec2 sine = p.xy * (0.5 / (far * greater));         // toward the ray
    float cosine = greater;
    if (p.z < 0.0) {
        float across = length(p.xy);
        sine = across > 1e-9 * far ? p.xy * (greater / across) : vec2(greater, 0.0);
        cosine = 0.5 * across / (far * greater);
    }
    return vec3(0.5 + sine / (shadow_rim * sqrt(0.5 + 0.5 * cosine)), (far - shadow_near) / (shadow_far - shadow_near));
}

vec3 from_light_space(vec3 place) {
    vec2 across = (2.0 * place.xy - 1.0) * shadow_rim;
    float quarter = dot(across, across) / 16.0;         // square of the sine of a quarter of the angle
    float cosine = 1.0 - 2.0 * quarter;                 // of half the angle
    vec3 along = vec3(across * (sqrt(max(1.0 - quarter, 0.0)) * cosine), 2.0 * cosine * cosine - 1.0);
    vec3 p = along * mix(shadow_near, shadow_far, place.z);
    return transpose(mat3(shadow_matrix)) * (p - shadow_matrix[3].xyz);
}
