// The union of two densities that are all but 1, and their intersection, all but 0: 2 to the power of the place from there.
// Result: union; intersection of the complements; what the densities are less than 1.
#include <boolean>
void main() {
    float gap = exp2(place());
    float a = 1.0 - gap, b = 1.0 - 0.5 * gap;
    Soft dense = Soft(a, vec3(0.0), -1.0, vec3(0.0, 0.0, 1.0), -1.0);
    Soft other = Soft(b, vec3(0.0), -1.0, vec3(0.0, 0.0, 1.0), -1.0);
    fragment = vec4(unite(dense, other).density, intersect(complement(dense), complement(other)).density, gap, 0.5 * gap);
}
