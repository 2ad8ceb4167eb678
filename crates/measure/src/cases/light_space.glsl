// Places of the space of shadows: directions on a meridian from one pole to the other, at a distance setting.w.
// setting.z: tangent of half the meridian's angle. Result: the place behind the way there and back; x of the light space.
const mat4 shadow_matrix = mat4(1.0);
const float shadow_rim = 2.8284271, shadow_near = 0.0, shadow_far = 4.0;
#include "light_space.glsl"
void main() {
    float z = place(), across = sqrt(max(1.0 - z * z, 0.0)), u = setting.z;
    vec3 p = setting.w * vec3(across * vec2(1.0 - u * u, 2.0 * u) / (1.0 + u * u), z);
    vec3 there = to_light_space(p);
    fragment = vec4(from_light_space(there), there.x);
}
