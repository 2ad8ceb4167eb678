// No shadows: a medium's own guess stands.
// Source: -
// Result: guess.
vec3 shadow(float guess, vec3 normal) { return vec3(guess); }
