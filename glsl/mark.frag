#version 450
#extension GL_EXT_samplerless_texture_functions : require
// Marks the pixels of a picture that no slice behind can change any more: they are as opaque as what ends a ray.
// Source: PH 3.1 (a ray ends where its opacity reaches 1); of slices, in batches, Krueger and Westermann 2003, whom GG 39.6
// names: a reconstruction, the chapter is cut.
// target_image: the picture so far. Result: a fragment where a pixel is marked, and none elsewhere.
#include "interface.glsl"
void main() {
    if (texelFetch(target_image, ivec2(gl_FragCoord.xy), 0).a < full_opacity) discard;
}
