// The normal of the distance, through the jacobian of the warp: that of the soft region before any DMF.
// Source: MJ 3.1, 6.
// s: a sample with 0 < density < 1; path: object units; result: unit normal, object space.
vec3 shading_normal(Sample s, float density, float path) { return s.normal; }
void remember(float density) {}
void enter(inout Sample s, inout float density, float path) {}
