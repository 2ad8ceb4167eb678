// The lean distance-field volume: the stored distance alone, in one channel; the normal, where one is asked for,
// comes from central differences one texel wide.
// Source: MJ 3.1 (distance), 2 (gradient).
// x: object space.
#include "surface_point.glsl"
#include <storage>

float volume_distance(vec3 tex_coord) { return distance_decode.x + distance_decode.y * volume_at(tex_coord).r; }

Surface object(vec3 x) {
    vec3 tex_coord = volume_scale.xyz * x + volume_offset.xyz;
    vec3 u = vec3(volume_texel.x, 0.0, 0.0), v = vec3(0.0, volume_texel.y, 0.0), w = vec3(0.0, 0.0, volume_texel.z);
    Surface surface;
    surface.distance = volume_distance(tex_coord);
    surface.normal = vec3(volume_distance(tex_coord + u) - volume_distance(tex_coord - u),
                          volume_distance(tex_coord + v) - volume_distance(tex_coord - v),
                          volume_distance(tex_coord + w) - volume_distance(tex_coord - w)) *
                     volume_scale.xyz / (2.0 * volume_texel.xyz);
    return surface;
}
