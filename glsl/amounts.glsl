// A warp or a DMF of some strength: 0 leaves what was there, 1 is the module alone, without a rounding, 2 is twice the change.
// Source: ours.
// amount: in [0, 2]; slope: its gradient by the point that the jacobian is the derivative by.
#define amounted(code) code
float with_amount(float before, float after, float amount) {
    return amount == 1.0 ? after : amount <= 0.0 ? before : before + amount * (after - before);
}

void with_amount(vec3 before, mat3 bent, float amount, vec3 slope, inout vec3 x, inout mat3 jacobian) {
    vec3 moved = x - before;
    jacobian = bent + amount * (jacobian - bent) + outerProduct(moved, slope);
    x = amount == 1.0 ? x : before + amount * moved;
}
