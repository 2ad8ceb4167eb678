// An integer hash: neighbors give bits that have nothing to do with each other.
// Source: PCG3D, Jarzynski and Olano 2020. No fract(sin()): drivers do not agree on the sine of a large number.
// Any integers; result uniform.
uvec3 hash(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    return v;
}
