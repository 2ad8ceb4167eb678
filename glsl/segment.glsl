// The part of a ray that one sample stands for: half a path to either side of it.
// Source: Engel, Kraus and Ertl 2001 (segments in place of points); where the matter begins in one is ours.
// x: object space, middle; path: object units; t: 0 at the end near to the eye, 1 at the far end.
vec3 to_far_end(float path) { return mat3(texture_matrix) * (to_eye() * -path); }

// Where a line from a at 0 to b at 1 has this value: 0 or 1 where it has it before or behind.
float place_of(float value, float a, float b) {
    float rise = b - a;
    return clamp((value - a) / (abs(rise) < 1e-20 ? -1e-20 : rise), 0.0, 1.0);
}

// Shading takes place at the surface, not in the middle of the step.
void look_from_middle_to(float t, float path) { position_eye -= to_eye() * ((t - 0.5) * path); }
