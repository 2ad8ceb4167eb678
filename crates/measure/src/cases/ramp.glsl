// A slab between z = 1/3 and z = -1/3 whose density falls linearly from 0.8 to 0.2, seen from +z.
// Source: -
// density: ignored; result in [0, 1].
float ramp(float density, Sample s) {
    float depth = 0.5 - 1.5 * s.x.z;
    return depth > 0.0 && depth < 1.0 ? mix(0.8, 0.2, depth) : 0.0;
}
