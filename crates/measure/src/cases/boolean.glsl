// Union of two densities 2^place below 1, and intersection of their complements.
// Result: union; intersection of the complements; distances of the densities from 1.
#include <boolean>
void main() {
    float gap = exp2(place());
    float a = 1.0 - gap, b = 1.0 - 0.5 * gap;
    Soft dense = Soft(a, vec3(0.0), -1.0, vec3(0.0, 0.0, 1.0), -1.0);
    Soft other = Soft(b, vec3(0.0), -1.0, vec3(0.0, 0.0, 1.0), -1.0);
    fragment = vec4(unite(dense, other).density, intersect(complement(dense), complement(other)).density, gap, 0.5 * gap);
}
