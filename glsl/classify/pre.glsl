// Pre-classification: the transfer map was applied to the voxels, and their colors are interpolated.
// Source: MJ 2 (the blocky one); opacity-weighted colors after Wittenbrink, Malzbender and Goss 1998.
// x: object space; path: object units; result premultiplied linear RGBA.
#include "distance_bound.glsl"
#include <filter>
#include <opacity>
#include <softness>           // of the voxels: density_table.frag

vec4 classify(vec3 x, float path) {
    vec4 matter = lookup_volume(classified_volume, volume_scale.xyz * x + volume_offset.xyz);
    float alpha = opacity(matter.a, opacity_rate * path);
    return vec4(matter.a > 0.0 ? matter.rgb / matter.a * alpha : vec3(0.0), alpha);
}
