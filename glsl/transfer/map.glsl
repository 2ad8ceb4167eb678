// The transfer map: color and opacity by density.
// Source: MJ 2 (post-classification), PH 2.4 and 3.1 (color maps).
// density in [0, 1]; the map is sampled at texel centers, so 0 and 1 hit its ends. Result: linear RGB, density in A.
// Outside matter, the lookup is beyond the first texel, where no device blends it with the second.
#include <filter>
vec4 transfer(float density) {
    float size = float(textureSize(transfer_map, 0));
    float at = density > 0.0 ? (density * (size - 1.0) + 0.5) / size : 0.0;
    return lookup_line(transfer_map, at);
}
