#version 450
#extension GL_EXT_samplerless_texture_functions : require
// Marks the pixels of a picture that no slice behind can change any more: they are as opaque as what ends a ray.
// Source: GG 39.6.2, early ray termination by slices in batches; PH 3.1.
// target_image: the picture so far. Result: a fragment where a pixel is marked, and none elsewhere.
#include "interface.glsl"
void main() {
    if (texelFetch(target_image, ivec2(gl_FragCoord.xy), 0).a < full_opacity) discard;
}
