// Opacity of a path through a medium whose extinction is c times its density.
// Source: Beer-Lambert law: 1 - exp(-c * density * path).
// density in [0, 1]; path >= 0, object units; result in [0, 1], relative error below 1e-6.
#include "exponential.glsl"

float opacity(float density, float path) {
    precise float depth = -opacity_rate * path * density;
    return depth < 0.0 ? -exp_minus_one(depth) : 0.0;
}
