// The space in which shadows are kept: rays from the light, by their angle from its axis, and the distance along them.
// Source: ours; opacity by distance from the light is kept as by Lokovic and Veach 2000 (deep shadow maps).
// position: eye space; place: in [0, 1] across the scene, x and y the ray, z the distance from the light.
// A light may be near the scene or inside of it: angles are those of a map, not of a picture, and reach half a turn.
vec3 to_light_space(vec3 position) {
    vec3 p = (shadow_matrix * vec4(position, 1.0)).xyz;
    float across = length(p.xy), far = length(p);
    vec2 side = across > 1e-6 * far ? p.xy / across : vec2(0.0);
    return vec3(0.5 + 0.5 * side * atan(across, p.z) / shadow_rim, (far - shadow_near) / (shadow_far - shadow_near));
}

vec3 from_light_space(vec3 place) {
    vec2 across = (2.0 * place.xy - 1.0) * shadow_rim;
    float angle = length(across);
    vec3 along = vec3(angle > 1e-9 ? across * (sin(angle) / angle) : across, cos(angle));
    vec3 p = along * mix(shadow_near, shadow_far, place.z);
    return transpose(mat3(shadow_matrix)) * (p - shadow_matrix[3].xyz);
}
