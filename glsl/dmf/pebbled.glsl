// Cells on the surface: the pads of leather, with grooves between them, or the hollows that a hammer leaves.
// Source: Worley 1996 (distances to the nearest and the second of scattered points), of whose patterns these are two.
// Geometry-dependent.
// density: D in [0, 1]; result in [0, 1]; the hard region keeps its own.
// @needs normal
// @outer pebble_height
// @param pebble_height = 0.05 in [0.005, 0.3]: Height of the relief, object units: the width of the soft region.
// @param pebbles = 9 in [0.5, 100]: Cells per object unit.
// @param hollow = 0 in [0, 1]: 0 are pads with grooves between them, 1 hollows with ridges between them.
#include "hash.glsl"
#include "relief.glsl"

// Distances from a place to the nearest and the second of the points, one in each cell of the lattice.
vec2 nearest_points(vec3 p) {
    vec3 cell = floor(p);
    vec2 near = vec2(4.0);
    for (int index = 0; index < 27; ++index) {
        vec3 other = cell + vec3(index % 3, index / 3 % 3, index / 9) - 1.0;
        vec3 inside = vec3(hash(uvec3(ivec3(other))) >> 8u) / 16777216.0;
        float away = length(other + 0.15 + 0.7 * inside - p);
        near = away < near.x ? vec2(away, near.x) : vec2(near.x, min(near.y, away));
    }
    return near;
}

float pebbled(float density, Sample s) {
    vec2 near = nearest_points(pebbles * foot_of(s));
    float groove = clamp(1.4 * (near.y - near.x), 0.0, 1.0);
    float pad = groove * (2.0 - groove), dent = min(near.x * near.x / 0.6, 1.0);
    return raised(density, s, mix(pad, dent, hollow));
}
