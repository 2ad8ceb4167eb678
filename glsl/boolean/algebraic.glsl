// Soft booleans by products: fillets as wide as the soft regions. No Boolean algebra: a and a is not a.
// Source: PH 2.2: a and b = a b; not a = 1 - a; a or b = a + b - a b.
// In the hard regions, where the density has no slope, distance and normal are those of the sharp operation.
#include "thin_matter.glsl"
Soft complement(Soft a) { return Soft(1.0 - a.density, -a.slope, -a.distance, -a.normal, -1.0); }

Soft intersect(Soft a, Soft b) {
    Soft further = a, nearer = b;
    if (b.distance > a.distance) {
        further = b;
        nearer = a;
    }
    if (enters_through(nearer, further)) further = nearer;
    return Soft(a.density * b.density, b.density * a.slope + a.density * b.slope, further.distance, further.normal,
                max(a.distance_bound, b.distance_bound));
}

Soft unite(Soft a, Soft b) {
    Soft nearer = a;
    if (b.distance < a.distance) nearer = b;
    return Soft(a.density + (1.0 - a.density) * b.density, (1.0 - b.density) * a.slope + (1.0 - a.density) * b.slope,
                nearer.distance, nearer.normal, min(a.distance_bound, b.distance_bound));
}
