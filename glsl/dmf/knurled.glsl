// Knurling: pyramids between two families of grooves that wind around the vertical axis, one to each side, as on a grip.
// Source: ours. Across the axis, grooves go by the height and the angle of the normal, so that they cross flat ends too.
// Geometry-dependent.
// density: D in [0, 1]; result in [0, 1]; the hard region keeps its own.
// @needs normal
// @outer knurl_height
// @param knurl_height = 0.05 in [0.005, 0.3]: Height of the pyramids, object units: the width of the soft region.
// @param knurls = 36 in [4, 400]: Grooves of each family around the axis.
// @param knurl_sharpness = 0.7 in [0.05, 1]: 1 is a point, less a flat top: the part of a pyramid that slopes.
#include "turns.glsl"
#include "relief.glsl"

float groove(float turns) { return min((1.0 - abs(2.0 * fract(turns) - 1.0)) / knurl_sharpness, 1.0); }

float knurled(float density, Sample s) {
    vec3 foot = foot_of(s);
    vec3 outward = safe_normalize(vec3(foot.x, 0.0, foot.z), vec3(1.0, 0.0, 0.0));
    float around = floor(knurls) * turns_of(foot.xz);           // whole grooves close around the axis
    float across = floor(0.3 * knurls) * turns_of(vec2(dot(s.normal, outward), s.normal.y)) + 0.16 * knurls * foot.y;
    return raised(density, s, min(groove(around + across), groove(around - across)));
}
