// A clear medium: it neither shines nor hides, and is seen by what it bends, reflects and absorbs.
// Source: PH 2.4 (blue glass).
// x: object space; path: object units; result: nothing.
// @outside empty
vec4 classify(vec3 x, float path) { return vec4(0.0); }
