// A cut-down point light, per fragment, in eye space.
// Source: MJ 3.2, 3.5.
// color: linear RGB; normal: unit, in object space or n in eye space; result: linear RGB.
// @needs normal
#include "eye_normal.glsl"
#include <shadow>
vec3 eye_lighting(vec3 color, vec3 n) {
    vec3 l = safe_normalize(light_position.xyz - position_eye, n);
    vec3 h = safe_normalize(l + to_eye(), n);
    float diffuse = max(dot(n, l), 0.0);
    float specular = diffuse > 0.0 ? pow(max(dot(n, h), 1e-6), specular_power) : 0.0;
    vec3 light = shadow(1.0, n) * light_color.rgb;
    return color * (ambient_color.rgb + diffuse * light) + specular_strength * specular * light;
}
vec3 lighting(vec3 color, vec3 normal) { return eye_lighting(color, eye_normal(normal)); }
