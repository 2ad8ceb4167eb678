// Where a ray enters hard matter of several objects, between the sample before and this one: there it is shaded.
// Source: ours: bisection of the step, since a boolean of densities has no distance to its surface.
// x: the sample; t: 0 there, 1 at the sample before, or less where a plane cuts the step.
struct Entry {
    vec3 back;          // to the sample before, object space
    float t;            // where the objects are asked next
    float inside;       // the last place known to be in hard matter, and the first that is not
    float outside;
    int turn;
};
const int HERE = 0, BEFORE = 1, LAST = 8;       // a 64th of the step between them

Entry entry(float path) { return Entry(mat3(texture_matrix) * (to_eye() * path), 0.0, 0.0, 1.0, HERE); }

// Whether the objects are asked again, at another t; density: at this one. A sample that stands for no step (ONE_SAMPLE)
// stays where it is.
bool goes_on(inout Entry at, vec3 x, float density) {
#ifdef ONE_SAMPLE
    return false;
#else
    if (at.turn == LAST || (at.turn == HERE && density < 1.0)) return false;
    if (at.turn == HERE) {
        at.outside = kept(x, at.back).y;
        at.t = at.outside;
    } else {
        if (density >= 1.0) at.inside = at.t;
        else at.outside = at.t;
        if (at.turn == BEFORE && density >= 1.0) {
            if (at.t < 1.0) return false;       // where it is cut open
            at.inside = 0.0;                    // the ray was inside before
            at.turn = LAST - 1;
        }
        at.t = at.turn == LAST - 1 ? at.inside : 0.5 * (at.inside + at.outside);
    }
    ++at.turn;
    return true;
#endif
}
