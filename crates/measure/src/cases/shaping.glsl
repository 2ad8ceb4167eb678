// Bias and gain by setting.z.
// Result: bias, gain, gain in the mirror, the place.
#include "shaping.glsl"
void main() {
    float t = place();
    fragment = vec4(bias(setting.z, t), gain(setting.z, t), gain(setting.z, 1.0 - t), t);
}
