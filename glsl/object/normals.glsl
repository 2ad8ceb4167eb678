// The distance-field volume of the paper: one fetch gives the normal in RGB and the stored distance in A.
// Source: MJ 3.1, 3.5.
// x: object space; beyond the volume the texels of its border extend outward.
#include "surface_point.glsl"
#include <storage>

Surface object(vec3 x) {
    vec3 tex_coord = volume_scale.xyz * x + volume_offset.xyz;
    vec4 v = volume_at(tex_coord);                              // MJ 3.1: rgb = normal, a = stored distance
    Surface surface;
    surface.distance = distance_decode.x + distance_decode.y * v.a; // positive outside from here on
    surface.normal = 2.0 * v.rgb - 1.0;                         // MJ 3.5: [0,1] -> [-1,1]
    return surface;
}
