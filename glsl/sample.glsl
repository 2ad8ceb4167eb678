// Samples the object at a point: displaced, softened.
// Source: MJ 6.
// x: object space; lengths in object units.
#include "sample_point.glsl"
#include <object>
#include <softness>
#include <warp>

Sample sample_object(vec3 x) {
    vec3 displaced = x;
    mat3 jacobian = mat3(1.0);
    displace(displaced, jacobian);
    Surface surface = object(displaced);
    Sample s;
    s.x = x;
    s.distance = surface.distance;
    s.normal = safe_normalize(transpose(jacobian) * surface.normal, vec3(0.0, 1.0, 0.0));
    s.shading = s.normal;
    s.coherence = length(surface.normal);
    s.density = soften(s.distance);
    s.distance_bound = s.distance - outer_iso_value - skip_slack;
    s.wide_normal = s.normal;
    s.hair_normal = s.normal;
    s.hair_tangent = s.normal;
    s.hair_length = outer_iso_value - iso_value;
    return s;
}
