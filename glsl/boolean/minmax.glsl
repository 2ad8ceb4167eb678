// Soft booleans of fuzzy sets: no fillets, and creases where the operands are equal.
// Source: PH 2.2, footnote: "interesting to try".
// Equal densities: the nearer surface counts for a union, the further for an intersection.
#include "thin_matter.glsl"
Soft complement(Soft a) { return Soft(1.0 - a.density, -a.slope, -a.distance, -a.normal, -1.0); }

Soft intersect(Soft a, Soft b) {
    bool second = b.density < a.density || (b.density == a.density && b.distance > a.distance);
    Soft chosen = a, other = b;
    if (second) {
        chosen = b;
        other = a;
    }
    if (a.density == b.density && enters_through(other, chosen)) chosen = other;
    chosen.distance_bound = max(a.distance_bound, b.distance_bound);
    return chosen;
}

Soft unite(Soft a, Soft b) {
    bool second = b.density > a.density || (b.density == a.density && b.distance < a.distance);
    Soft chosen = a;
    if (second) chosen = b;
    chosen.distance_bound = min(a.distance_bound, b.distance_bound);
    return chosen;
}
