// What a point of space holds: the inputs of a DMF, a surface and a medium.
// Source: MJ 6 (the variables available to a DMF).
// x: object space; lengths in object units.
#include <object>
#include <softness>
#include <warp>

struct Sample {
    vec3 x;             // object position
    float distance;     // signed distance to the surface, positive outside
    vec3 normal;        // unit gradient of the distance, object space
    float coherence;    // length of the interpolated gradient: 1, but less where the nearest surface changes sides
    float density;      // D in [0, 1]: 1 is the hard region, 0 is outside, between is the soft region
};

// Distance from the last sample to the soft region, less than 0 inside of it: how far a ray may leap.
float clearance = 0.0;

Sample sample_object(vec3 x) {
    vec3 displaced = x;
    mat3 jacobian = mat3(1.0);
    displace(displaced, jacobian);
    Surface surface = object(displaced);
    clearance = surface.distance - outer_iso_value;
    Sample s;
    s.x = x;
    s.distance = surface.distance;
    s.normal = cap_normal(x, safe_normalize(transpose(jacobian) * surface.normal, vec3(0.0, 1.0, 0.0)));
    s.coherence = length(surface.normal);
    s.density = soften(s.distance);
    return s;
}
