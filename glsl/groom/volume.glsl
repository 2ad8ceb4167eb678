// A groom: channels painted in space over the object, which modules read at its skin.
// Source: MJ 2 and 7 (texturing without parameterization); the channels are ours.
// x: object space. Results: length, density and amount are factors in [0, 2], and 1 where nothing is painted; the direction
// is a tangent, at most 1 along each axis.
#include <filter>
#define groomed(code) code
const float GROOM_REACH = 1.125;        // the volume is the cube from -1.125 to 1.125, object units

vec3 groom_place(vec3 x) { return x * (0.5 / GROOM_REACH) + 0.5; }
vec4 groom_shape(vec3 x) { return lookup_volume(groom_shape_volume, groom_place(x)); }
vec4 groom_look(vec3 x) { return lookup_volume(groom_look_volume, groom_place(x)); }

float groom_length(vec3 x) { return groom_shape(x).a; }
vec3 groom_direction(vec3 x) { return groom_shape(x).rgb; }
float groom_density(vec3 x) { return groom_look(x).a; }
float groom_amount(vec3 x) { return lookup_volume(groom_amount_volume, groom_place(x)).r; }

// The gradient of a length of at most 1, per object unit, over a voxel to each side.
vec3 groom_slope(vec3 x) {
    float reach = 2.0 * GROOM_REACH / float(textureSize(groom_shape_volume, 0).x);
    vec3 u = vec3(reach, 0.0, 0.0), v = u.yxy, w = u.yyx;
    return (min(vec3(groom_length(x + u), groom_length(x + v), groom_length(x + w)), 1.0)
            - min(vec3(groom_length(x - u), groom_length(x - v), groom_length(x - w)), 1.0)) / (2.0 * reach);
}

// The gradient of the amount, likewise.
vec3 groom_amount_slope(vec3 x) {
    float reach = 2.0 * GROOM_REACH / float(textureSize(groom_amount_volume, 0).x);
    vec3 u = vec3(reach, 0.0, 0.0), v = u.yxy, w = u.yyx;
    return (vec3(groom_amount(x + u), groom_amount(x + v), groom_amount(x + w))
            - vec3(groom_amount(x - u), groom_amount(x - v), groom_amount(x - w))) / (2.0 * reach);
}

// The painted color: each channel of 0 is black, of 1 that of the effect, of 2 full.
vec3 groom_color(vec3 own, vec3 x) {
    vec3 painted = groom_look(x).rgb;
    return own * min(painted, 1.0) + max(1.0 - own, 0.0) * max(painted - 1.0, 0.0);
}

// The density of a soft region that is as wide as the painted length says, as a part of its width.
float groom_depth(float density, vec3 x) {
    return density >= 1.0 ? density : max(1.0 - (1.0 - density) / clamp(groom_length(x), 1e-3, 1.0), 0.0);
}
