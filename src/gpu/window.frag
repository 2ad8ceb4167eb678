#version 450
// A fragment of the window. Colors are premultiplied codes, mixed as codes as in every other program.
layout(constant_id = 0) const bool LINEAR = false; // whether the target takes linear light
layout(binding = 0) uniform texture2D texels;
layout(binding = 1) uniform sampler linear_sampler;
layout(location = 0) in vec2 texel;
layout(location = 1) in vec4 tint;
layout(location = 0) out vec4 color;

void main() {
    color = tint * texture(sampler2D(texels, linear_sampler), texel);
    if (LINEAR) {
        vec3 high = pow((color.rgb + 0.055) / 1.055, vec3(2.4));
        color.rgb = mix(high, color.rgb / 12.92, lessThanEqual(color.rgb, vec3(0.04045)));
    }
}
