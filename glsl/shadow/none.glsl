// No shadows: a medium's own guess stands.
// Source: -
// Result: guess.
float shadow(float guess, vec3 normal) { return guess; }
