// A relief that stands on an object: its soft region, filled up to a height.
// Source: ours.
// Heights are parts of the width of the soft region, in [0, 1], taken at the foot of a place: one column stands on each
// point of the object, so that the matter is one body.
const float RELIEF_EDGE = 0.15;         // over which the density falls at the top, the same part

vec3 foot_of(Sample s) { return s.x - (s.distance - iso_value) * s.normal; }

// density: D in [0, 1]; result in [0, 1]: the hard region keeps its own.
float raised(float density, Sample s, float height) {
    if (s.density >= 1.0) return density;
    return clamp(((1.0 + RELIEF_EDGE) * height - (1.0 - s.density)) / RELIEF_EDGE, 0.0, 1.0);
}
