// A point moved along its radius: x (1 + amount).
// Source: PH 2.4 (noisy sphere, fractal sphere, fire ball).
// x: object space; jacobian: derivative of the displaced by the original point; slope: gradient of the amount by x.
// Beyond HELD_RADIUS the step stays as long as it is there, so that no amount moves a point by more than
// amount * HELD_RADIUS: otherwise an amount of -1 would reach the object from any distance, and it would have no bounds.
const float HELD_RADIUS = 1.1547005;    // 1 / 0.866: a noise of amplitude a moves no point further than a

void scale_radius(inout vec3 x, inout mat3 jacobian, float amount, vec3 slope) {
    float r = length(x);
    bool held = r > HELD_RADIUS;
    vec3 arm = held ? x * (HELD_RADIUS / r) : x;
    mat3 bend = held ? (HELD_RADIUS / r) * (mat3(1.0) - outerProduct(x, x) / (r * r)) : mat3(1.0);
    jacobian = (mat3(1.0) + amount * bend + outerProduct(arm, slope)) * jacobian;
    x += amount * arm;
}
