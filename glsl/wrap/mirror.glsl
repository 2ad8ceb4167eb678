// Every other period is mirrored.
// Source: MJ 4.1 (GL_MIRRORED_REPEAT); that the gradient changes its sign where it is mirrored, the paper does not say.
// p and period: lattice cells. folded: where in the first period the noise of p is found; fold_sign: what the gradient
// there is multiplied by. What never repeats has no mirror.
const float NEVER = 1048576.0;

vec3 from_mirror(vec3 p, float period) { return p - 2.0 * period * floor(p / (2.0 * period) + 0.5); }
vec3 folded(vec3 p, float period) { return period < NEVER ? abs(from_mirror(p, period)) : p; }
vec3 fold_sign(vec3 p, float period) {
    return period < NEVER ? mix(vec3(1.0), vec3(-1.0), lessThan(from_mirror(p, period), vec3(0.0))) : vec3(1.0);
}
