// Noise computed in place from an integer hash: no memory, no visible period below 2^20 cells.
// Source: PH 2.3 (lattice gradients); the hash is PCG3D, Jarzynski and Olano 2020.
// p: lattice cells; result: gradient per cell in xyz, noise in w, |noise| <= 0.87.
#include "hash.glsl"
#include <weights>

// A unit vector, uniform on the sphere, for each lattice point.
vec3 lattice_gradient(ivec3 cell) {
    uvec3 bits = hash(uvec3(cell));
    float z = float(bits.x) * (2.0 / 4294967296.0) - 1.0;
    float angle = float(bits.y) * (6.283185307179586 / 4294967296.0);
    return vec3(sqrt(max(1.0 - z * z, 0.0)) * vec2(cos(angle), sin(angle)), z);
}

vec4 noise_gradient(vec3 p) {
    vec3 base = floor(clamp(p, vec3(-1e6), vec3(1e6)));
    ivec3 cell = ivec3(base);
    vec3 t = p - base;
    vec3 w = fade(t);
    vec3 dw = fade_slope(t);
    vec4 sum = vec4(0.0);
    for (int corner = 0; corner < 8; ++corner) {
        ivec3 offset = ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        vec3 gradient = lattice_gradient(cell + offset);
        vec3 side = vec3(offset);
        vec3 weight = mix(1.0 - w, w, side);
        vec3 slope = dw * (2.0 * side - 1.0);
        float value = dot(gradient, t - side);
        float product = weight.x * weight.y * weight.z;
        sum.w += product * value;
        sum.xyz += product * gradient + value * vec3(slope.x * weight.y * weight.z,
                                                     slope.y * weight.x * weight.z,
                                                     slope.z * weight.x * weight.y);
    }
    return sum;
}
float noise(vec3 p) { return noise_gradient(p).w; }
