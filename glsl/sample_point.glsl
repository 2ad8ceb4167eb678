// What a DMF, a surface and a medium know about a point of space.
// Source: MJ 6 (the variables available to a DMF).
// Object space and object units.
struct Sample {
    vec3 x;             // object position
    float distance;     // signed distance to the surface, positive outside
    vec3 normal;        // unit gradient of the distance, object space
    vec3 shading;       // unit normal that soft matter is lit by: slot <gradient>; the same as normal elsewhere
    float coherence;    // length of the interpolated gradient: 1, but less where the nearest surface changes sides
    float density;      // D in [0, 1]: 1 is the hard region, 0 is outside, between is the soft region
};
