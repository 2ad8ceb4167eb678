// A point moved along its radius: x (1 + amount).
// Source: PH 2.4 (noisy sphere, fractal sphere, fire ball).
// x: object space; jacobian: derivative of the displaced by the original point; slope: gradient of the amount by x.
// Beyond hold_radius the step stays as long as it is there: otherwise an amount of -1 would reach the object from any
// distance, and it would have no bounds. Where the amounts leave it bounds, no matter is beyond hold_radius.
// Noise that moves matter comes with its gradient where `takes_slope`: the noise alone takes fewer fetches and operations.
// The compiler leaves out the argument that is not asked for.
bool takes_slope = true;
vec4 moved_by(vec4 gradient, float noise) { return takes_slope ? gradient : vec4(vec3(0.0), noise); }

void scale_radius(inout vec3 x, inout mat3 jacobian, float amount, vec3 slope) {
    float r = length(x);
    bool held = r > hold_radius;
    vec3 arm = held ? x * (hold_radius / r) : x;
    mat3 bend = held ? (hold_radius / r) * (mat3(1.0) - outerProduct(x, x) / (r * r)) : mat3(1.0);
    jacobian = (mat3(1.0) + amount * bend + outerProduct(arm, slope)) * jacobian;
    x += amount * arm;
}
