// How a part prints: overhangs and thin walls in colors of their own, lit.
// Source: ours; layers of most printers carry themselves up to 45 degrees.
// Result: linear RGB: red where the surface hangs over, blue where a wall is thin, violet where both are.
// @param overhang_angle = 45 in [0, 89]: Undersides that lean by more than this from the vertical are red, degrees.
// @param least_wall = 0.05 in [0, 0.5]: Walls thinner than this are blue, object units.
#include <object>
#include "lighting.glsl"
const int WALL_STEPS = 8;

// Whether the other side of a wall is within a length.
bool is_thin(Sample s, float most) {
    bool thin = false;
    for (int step = 1; step <= WALL_STEPS; ++step) {
        float depth = most * float(step) / float(WALL_STEPS);
        thin = thin || object(s.x - depth * s.normal).distance > iso_value;
    }
    return thin;
}

vec3 surface(Sample s) {
    bool hangs = s.normal.y < -sin(radians(overhang_angle));
    vec3 own = hangs ? vec3(0.8, 0.05, 0.03) : color.rgb * material_color.rgb;
    if (is_thin(s, least_wall)) own = hangs ? vec3(0.4, 0.07, 0.4) : vec3(0.03, 0.1, 0.8);
    return lighting(own, s.normal);
}
