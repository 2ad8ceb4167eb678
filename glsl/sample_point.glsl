// Inputs of DMFs, surfaces and media at a point of space, and values that one passes to another.
// Source: MJ 6 (the variables available to a DMF).
// Object space and object units. A DMF that leaves something takes `inout Sample s`; no sample sees what was left in
// another, so that a probe beside it changes nothing.
#include <groom>
#include <amount>
struct Sample {
    vec3 x;             // object position
    float distance;     // signed distance to the surface, positive outside
    vec3 normal;        // unit gradient of the distance, object space
    vec3 shading;       // unit normal that soft matter is lit by: slot <gradient>; the same as normal elsewhere
    float coherence;    // length of the interpolated gradient: 1, but less where the nearest surface changes sides
    float density;      // D in [0, 1]: 1 is the hard region, 0 is outside, between is the soft region
    float distance_bound;    // distance to the soft region, less than 0 inside of it: no matter is nearer
    vec3 wide_normal;   // gradient of the distance over a length, at most 1 long: left by a DMF of flames, else the normal
    vec3 hair_normal;   // unit normal of the skin at the root of the hair here: left by a DMF that grows hair (PH 4)
    vec3 hair_tangent;  // unit vector along that hair, towards its tip
    float hair_length;  // of the hair here, object units: left by a DMF that grows it; the soft region's width elsewhere
    groomed(vec3 root;)     // where the skin is painted for this place: the foot, or the root left by a DMF that grows hair
};

const float BELOW_ONE = 0.99999994;     // the largest density of soft matter in f32
