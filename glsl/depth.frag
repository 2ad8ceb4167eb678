#version 450
// Depth at which one ray through the picture has met an opacity of 1/2.
// Source: ours; the samples are those of PH 3.1: see march.glsl.
// Result: depth along the axis of view, object units; infinite where the opacity stays below 1/2.
#include "interface.glsl"
#include "vector.glsl"
#define TEXEL r32f
#include "trace.glsl"
vec3 position_eye;                      // eye space
float half_depth = uintBitsToFloat(0x7F800000u);

// A sample stands for half a step to either side, all alike; opaque matter begins where it was located.
// opacity_before: of all in front; alpha: of the sample; k: steps behind the first slice; result: opacity with it.
float ray_meets(float opacity_before, float alpha, float k) {
    float opacity_now = opacity_before + (1.0 - opacity_before) * alpha;
    if (opacity_now >= 0.5) {
        float part = log(0.5 / (1.0 - opacity_before)) / log(1.0 - alpha);
        half_depth = alpha >= 1.0 ? -position_eye.z : first_depth + (k - 0.5 + part) * step_size;
    }
    return opacity_now;
}

#define MEETS(matter, k) sum.a = ray_meets(sum.a, (matter).a, k)
#define ENDS sum.a >= 0.5
#define GIVES half_depth
#include "march.glsl"
