// A cut-down point light, per fragment, in eye space.
// Source: MJ 3.2, 3.5.
// color: linear RGB; normal: unit, object space; result: linear RGB.
// @needs normal
#include <shadow>
vec3 lighting(vec3 color, vec3 normal) {
    vec3 n = safe_normalize(mat3(normal_matrix) * normal, to_eye());     // MJ 3.5: into eye space
    vec3 l = safe_normalize(light_position.xyz - position_eye, n);
    vec3 h = safe_normalize(l + to_eye(), n);
    float diffuse = max(dot(n, l), 0.0);
    float specular = diffuse > 0.0 ? pow(max(dot(n, h), 1e-6), specular_power) : 0.0;
    vec3 light = shadow(1.0, n) * light_color.rgb;
    return color * (ambient_color.rgb + diffuse * light) + specular_strength * specular * light;
}
