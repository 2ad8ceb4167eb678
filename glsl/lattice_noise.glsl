// Gradient noise of a lattice whose directions come from an integer hash: no memory, and a period that can be chosen.
// Source: PH 2.3 (lattice gradients); a hash in place of its tables. Each lattice point has one of 24 directions, (a, a, c)
// in every order and with every sign, whose moments up to the fifth order are those of the sphere: none is favored.
// crates/noise/src/lattice.rs is the same noise in f64, of which the blocks are made.
// p: lattice cells; mask: one less than the cells after which the lattice repeats, a power of two up to 2^20; result:
// |noise| <= 0.866, gradient per cell in xyz and noise in w.
#include "corners.glsl"
#include <wrap>
const float MINOR = 0.35002117;     // a
const float MAJOR = 0.86889030;     // c; 2 a^2 + c^2 = 1 and 2 a^4 + c^4 = 3 / 5
const float FARTHEST = 1048576.0;   // cells from the origin; beyond, the noise is that of this border
const uvec3 STRIDE = uvec3(0x8da6b343u, 0xd8163841u, 0xcb1ab31fu);

uint scattered(uint point) {
    uint h = point * 0x27d4eb2du;
    return h ^ (h >> 15u);
}

// The direction of a lattice point, as its dot product with an offset and as a vector.
float knot(uint point, float x, float y, float z) {
    uint h = scattered(point);
    x = mix(x, -x, (h & 1u) != 0u);
    y = mix(y, -y, (h & 2u) != 0u);
    z = mix(z, -z, (h & 4u) != 0u);
    float major = mix(mix(z, y, h < 0xaaaaaaaau), x, h < 0x55555555u);
    return MINOR * (x + y + z) + (MAJOR - MINOR) * major;
}

vec3 direction(uint point) {
    uint h = scattered(point);
    vec3 sides = mix(vec3(1.0), vec3(-1.0), notEqual(h & uvec3(1u, 2u, 4u), uvec3(0u)));
    bool first = h < 0x55555555u, last = h >= 0xaaaaaaaau;
    return sides * mix(vec3(MINOR), vec3(MAJOR), bvec3(first, !first && !last, last));
}

float lattice_noise(vec3 p, uint mask) {
    vec3 inside = clamp(folded(p, float(mask + 1u)), vec3(-FARTHEST), vec3(FARTHEST)), base = floor(inside);
    vec3 t = inside - base, s = t - 1.0, w = fade(t);
    uvec3 cell = uvec3(ivec3(base));
    uvec3 a = (cell & mask) * STRIDE, b = ((cell + 1u) & mask) * STRIDE;
    uint aa = a.y ^ a.z, ba = b.y ^ a.z, ab = a.y ^ b.z, bb = b.y ^ b.z;
    float y0 = between(knot(a.x ^ aa, t.x, t.y, t.z), knot(b.x ^ aa, s.x, t.y, t.z), w.x);
    float y1 = between(knot(a.x ^ ba, t.x, s.y, t.z), knot(b.x ^ ba, s.x, s.y, t.z), w.x);
    float y2 = between(knot(a.x ^ ab, t.x, t.y, s.z), knot(b.x ^ ab, s.x, t.y, s.z), w.x);
    float y3 = between(knot(a.x ^ bb, t.x, s.y, s.z), knot(b.x ^ bb, s.x, s.y, s.z), w.x);
    return between(between(y0, y1, w.y), between(y2, y3, w.y), w.z);
}

vec4 lattice_noise_gradient(vec3 p, uint mask) {
    vec3 inside = clamp(folded(p, float(mask + 1u)), vec3(-FARTHEST), vec3(FARTHEST)), base = floor(inside);
    uvec3 cell = uvec3(ivec3(base));
    uvec3 a = (cell & mask) * STRIDE, b = ((cell + 1u) & mask) * STRIDE;
    uint aa = a.y ^ a.z, ba = b.y ^ a.z, ab = a.y ^ b.z, bb = b.y ^ b.z;
    vec4 n = noise_of_corners(inside - base,
                              direction(a.x ^ aa), direction(b.x ^ aa), direction(a.x ^ ba), direction(b.x ^ ba),
                              direction(a.x ^ ab), direction(b.x ^ ab), direction(a.x ^ bb), direction(b.x ^ bb));
    return vec4(n.xyz * fold_sign(p, float(mask + 1u)), n.w);
}
