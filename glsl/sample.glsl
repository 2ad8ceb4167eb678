// Samples the object at a point: displaced, softened.
// Source: MJ 6.
// x: object space; lengths in object units. The point is displaced once for the distance and once for the normal: mostly, a
// sample is asked for one of the two, and the compiler leaves the other out.
#include "sample_point.glsl"
#include "scale_radius.glsl"
#include <object>
#include <softness>
#include <warp>

Sample sample_object(vec3 x) {
    vec3 displaced = x, shaded = x;
    mat3 jacobian = mat3(1.0), unset = mat3(1.0);
    takes_slope = false;
    displace(displaced, unset);
    takes_slope = true;
    displace(shaded, jacobian);
    Sample s;
    s.x = x;
    s.distance = object(displaced).distance;
    vec3 normal = object(shaded).normal;
    s.normal = safe_normalize(transpose(jacobian) * normal, vec3(0.0, 1.0, 0.0));
    s.shading = s.normal;
    s.coherence = length(normal);
    s.density = soften(s.distance);
    s.distance_bound = s.distance - outer_iso_value - skip_slack;
    s.wide_normal = s.normal;
    s.hair_normal = s.normal;
    s.hair_tangent = s.normal;
    s.hair_length = outer_iso_value - iso_value;
    groomed(s.root = x - (s.distance - iso_value) * s.normal;)
    return s;
}
