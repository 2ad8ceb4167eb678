#version 450
// Texels of a noise block, as an upload holds them, for src/render/inputs/device_blocks.rs. An invocation writes four
// numbers: four values, or a texel of four channels.
// Source: MJ 4.1; crates/noise/src/bake.rs makes the same blocks on a CPU.
// Result: value times SCALE plus OFFSET, and slope times SLOPE plus 1/2, in codes of BITS bits.
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) writeonly buffer Words { uint words[]; };
layout(push_constant) uniform Level {
    uint side;              // texels along a side
    uint octaves;           // summed octaves
    float raised;           // mean of the octaves that the level lacks
    uint first;             // invocations before this dispatch
};
layout(constant_id = 1) const uint CELLS = 4u;          // lattice cells of the first octave along a side
const uint VALUES = 0u, GRADIENTS = 1u;                  // else four octaves of noise
layout(constant_id = 2) const uint KIND = 0u;
layout(constant_id = 3) const bool SUMS = false;        // turbulence in place of noise
layout(constant_id = 4) const uint BITS = 32u;
layout(constant_id = 5) const float SCALE = 1.0;
layout(constant_id = 6) const float OFFSET = 0.0;
layout(constant_id = 7) const float SLOPE = 1.0;
#include "lattice_noise.glsl"
#include "octave_sum.glsl"
uint mask(int index) { return (CELLS << index) - 1u; }
int octaves_held() { return int(octaves); }
float octave(vec3 p, int index) { return lattice_noise(p, mask(index)); }
vec4 octave_gradient(vec3 p, int index) { return lattice_noise_gradient(p, mask(index)); }

// The center of a texel, lattice cells.
vec3 center(uint texel) {
    uvec3 at = uvec3(texel, texel / side, texel / (side * side)) % side;
    return (vec3(at) + 0.5) * (float(CELLS) / float(side));
}
float stored(float value) { return OFFSET + SCALE * (value + raised); }
float value(uint texel) { return stored(SUMS ? turbulence(center(texel)) : octave(center(texel), 0)); }
vec4 gradient(uint texel) {
    vec4 n = SUMS ? turbulence_gradient(center(texel)) : octave_gradient(center(texel), 0);
    return vec4(0.5 + SLOPE * n.xyz, stored(n.w));
}
float channel(uint texel, int index) { return stored(octave(exp2(float(index)) * center(texel), index)); }

void main() {
    uint index = gl_GlobalInvocationID.x, at = index * (BITS / 8u), number = first + index;
    if (at + BITS / 8u > words.length()) return;
    vec4 numbers = KIND == VALUES
        ? vec4(value(4u * number), value(4u * number + 1u), value(4u * number + 2u), value(4u * number + 3u))
        : KIND == GRADIENTS
        ? gradient(number)
        : vec4(channel(number, 0), channel(number, 1), channel(number, 2), channel(number, 3));
    if (BITS == 8u) words[at] = packUnorm4x8(numbers);
    else if (BITS == 16u) {
        words[at] = packUnorm2x16(numbers.xy);
        words[at + 1u] = packUnorm2x16(numbers.zw);
    } else for (int c = 0; c < 4; ++c) words[at + c] = floatBitsToUint(numbers[c]);
}
