// The side by which a ray enters hard matter that is thinner than a step.
// Source: ours.
// A file of its own, since every object has a copy of the files with variables, and objects share `Soft`.
#include "soft.glsl"

// Two surfaces of hard matter that are nearer to each other, in steps, are told apart by the side that the ray comes from.
const float THIN = 0.5;

// Where a ray enters hard matter: the way to the eye, object space, and how far apart two surfaces may be of which it meets
// the one that faces it. In matter thinner than a step, what is nearer to a place inside may be the far side.
vec3 entered_from = vec3(0.0);
float entry_reach = 0.0;

// Whether the ray enters through the surface of `other` where that of `chosen` would be nearer.
bool enters_through(Soft other, Soft chosen) {
    return abs(chosen.distance - other.distance) < entry_reach && dot(chosen.normal, entered_from) < 0.0 &&
           dot(other.normal, entered_from) > 0.0;
}
