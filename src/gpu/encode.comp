#version 450
// A picture as a texture of the window: codes over a background, or with an alpha for the blend over both gray levels of
// the checkerboard. crates/viewer/src/screen/pictures.rs encodes pictures of the host so.
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant) uniform Area { ivec2 first, end; };
layout(binding = 0) uniform texture2D light; // premultiplied, linear
layout(binding = 1) uniform sampler fetched;
layout(binding = 2) uniform Behind { vec4 dark, bright; }; // linear light, and the code of a gray level; a background twice
layout(binding = 3, rgba8) uniform writeonly image2D picture;

vec3 code(vec3 light) {
    vec3 held = clamp(light, 0.0, 1.0);
    return mix(1.055 * pow(held, vec3(1.0 / 2.4)) - 0.055, 12.92 * held, lessThanEqual(held, vec3(0.0031308)));
}

void main() {
    ivec2 pixel = first + ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, end))) return;
    vec4 own = texelFetch(sampler2D(light, fetched), pixel, 0);
    vec3 low = code(own.rgb + (1.0 - own.a) * dark.rgb), high = code(own.rgb + (1.0 - own.a) * bright.rgb);
    float range = bright.w - dark.w;
    float through = range > 0.0 ? dot(high - low, vec3(1.0 / 3.0)) / range : 0.0;
    imageStore(picture, pixel, vec4(0.5 * (low + high - through * (dark.w + bright.w)), 1.0 - through));
}
