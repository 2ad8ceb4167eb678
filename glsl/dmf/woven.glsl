// Woven cloth: two sets of threads in the soft region, each over and under the other by turns.
// Source: PH 1 promises woven materials and prints no formula: a reconstruction. One set runs around the vertical axis,
// the other across it, by the angle of the normal and the height. Geometry-dependent.
// density: D in [0, 1]; result in [0, 1]; the hard region keeps its own.
// @needs normal
// @groom density
// @outer cloth_thickness
// @param cloth_thickness = 0.07 in [0.01, 0.3]: Thickness of the cloth, object units: the width of the soft region.
// @param threads = 48 in [4, 400]: Threads around the vertical axis.
// @param thread_width = 0.85 in [0.2, 1]: Width of a thread, as a part of the distance between two.
#include "turns.glsl"

// How deep a point lies in the nearest thread of either set: 1 in its middle, 0 at its border and beyond.
vec2 thread_depths(Sample s) {
    vec3 root = s.x - (s.distance - iso_value) * s.normal;
    vec3 outward = safe_normalize(vec3(root.x, 0.0, root.z), vec3(1.0, 0.0, 0.0));
    float pairs = floor(0.5 * threads);                         // whole pairs: over and under close around the axis
    float u = 2.0 * pairs * (0.5 + turns_of(root.xz));
    float tilt = turns_of(vec2(dot(s.normal, outward), s.normal.y));
    float v = 2.0 * floor(0.3 * pairs) * tilt + 0.2 * pairs * root.y;
    float z = 1.0 - s.density;                                  // 0 on the object, 1 on the outside of the cloth
    // Half a wave of each thread for each thread that it crosses, up where the other one is down.
    vec2 number = floor(vec2(u, v)), part = fract(vec2(u, v));
    float up = 0.25 - 0.5 * mod(number.x + number.y, 2.0);
    vec2 height = 0.5 + vec2(up * half_wave(part.y), -up * half_wave(part.x));
    vec2 aside = (part - 0.5) * (2.0 / thread_width);
    vec2 above = (z - height) * 4.0;
    return max(1.0 - aside * aside - above * above, 0.0);
}

float woven(float density, Sample s) {
    if (s.density >= 1.0) return density;
    vec2 depth = thread_depths(s);
    groomed(depth -= max(1.0 - groom_density(s.root), 0.0);)
    return clamp(3.0 * max(depth.x, depth.y), 0.0, 1.0);
}
