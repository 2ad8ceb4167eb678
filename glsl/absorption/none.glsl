// Nothing is absorbed.
// Source: -
// amount: integral of the density along the path, object units; result: what comes through, linear RGB.
vec3 transmitted(float amount) { return vec3(1.0); }
