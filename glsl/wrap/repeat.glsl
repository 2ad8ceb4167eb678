// Periods are alike.
// Source: MJ 4.1 (GL_REPEAT).
// p and period: lattice cells. folded: p, or where in the first period its noise is found; fold_sign: what the gradient
// there is multiplied by.
vec3 folded(vec3 p, float period) { return p; }
vec3 fold_sign(vec3 p, float period) { return vec3(1.0); }
