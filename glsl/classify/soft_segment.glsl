// A hypertextured object, by segments: the density is linear between the two ends of each step, and the hard region
// begins where such a line says.
// Source: MJ 6; the opacity is that of PH 3.1 for such a segment, and of the second order.
// x: object space, middle of the step; path: object units; result premultiplied linear RGBA.
#include "sample.glsl"
#include "segment.glsl"
#include "distance_bound.glsl"
#include <dmf>
#include <opacity>
#include <gradient>
#include <surface>
#include <medium>

struct End {
    Sample s;
    float unclamped;    // density before any DMF, beyond [0, 1] as well
    float density;      // modulated, in [0, 1]
};
End far_end;            // of the step before, along a ray
float far_part = 0.0;   // how much of that step was left by what cuts it: 1 where it ends where this one begins

// The places of a segment where its density is asked for.
const int NEAR = 0, FAR = 1, OVER_SKIN = 2, UNDER_SKIN = 3;

// Linear interpolation between two ends: the sample at part t.
Sample between(Sample a, Sample b, float t) {
    Sample s = a;
    s.x = mix(a.x, b.x, t);
    s.distance = mix(a.distance, b.distance, t);
    s.normal = safe_normalize(mix(a.normal, b.normal, t), a.normal);
    s.shading = s.normal;
    s.coherence = mix(a.coherence, b.coherence, t);
    s.wide_normal = mix(a.wide_normal, b.wide_normal, t);
    s.hair_normal = safe_normalize(mix(a.hair_normal, b.hair_normal, t), a.hair_normal);
    s.hair_tangent = safe_normalize(mix(a.hair_tangent, b.hair_tangent, t), a.hair_tangent);
    s.hair_length = mix(a.hair_length, b.hair_length, t);
    return s;
}

vec4 classify(vec3 x, float path) {
    vec3 along = to_far_end(path), from = x - 0.5 * along;
    vec2 part = kept(from, along);
    End a = far_end, b = far_end;
    Sample under = a.s;
    float d_over = 0.0, d_under = 0.0, skin = 0.0, edge = 0.0;
    bool entering = false, within = false;
    vec2 soft = vec2(0.0), hard = vec2(0.0);
    // A program holds what gives the density once, and a device that runs both sides of a branch leaves a loop.
    int first = follows && far_part >= 1.0 && part.x <= 0.0 ? FAR : NEAR;
    for (int place = first; place <= (within ? UNDER_SKIN : FAR); ++place) {
        Sample s = sample_object(from + (place == NEAR ? part.x : place == FAR ? part.y : mix(part.x, part.y, skin)) * along);
        float unclamped = soften_unclamped(s.distance);
        if (place > FAR) s.density = place == OVER_SKIN ? BELOW_ONE : 1.0;
        float density = s.density > 0.0 ? clamp(modulate(s.density, s), 0.0, 1.0) : 0.0;
        if (place == NEAR) a = End(s, unclamped, density);
        if (place == OVER_SKIN) d_over = density;
        if (place == UNDER_SKIN) {
            d_under = density;
            under = s;
        }
        if (place == FAR) {
            b = End(s, unclamped, density);
            // Where the hard and the soft region begin and end, from 0 at a to 1 at b.
            entering = b.unclamped > a.unclamped;
            skin = place_of(1.0, a.unclamped, b.unclamped);
            edge = place_of(0.0, a.unclamped, b.unclamped);
            soft = entering ? vec2(edge, skin) : vec2(skin, edge);
            hard = entering ? vec2(skin, 1.0) : vec2(0.0, skin);
            within = part.x <= part.y && hard.y > hard.x && soft.y > soft.x;
        }
    }
    far_end = b;
    far_part = part.y;
    distance_bound = part.y < 1.0 ? 0.0 : b.s.distance_bound;
    if (part.x > part.y || max(a.unclamped, b.unclamped) <= 0.0) {
        remember(0.0);
        return vec4(0.0);
    }
    float amount = opacity_rate * path * (part.y - part.x);
    vec3 middle_eye = position_eye;
    vec4 hard_matter = vec4(0.0), soft_matter = vec4(0.0);
    if (soft.y > soft.x) {
        float d0 = entering ? (edge > 0.0 ? 0.0 : a.density) : (within ? d_over : a.density);
        float d1 = entering ? (within ? d_over : b.density) : (edge < 1.0 ? 0.0 : b.density);
        float density = 0.5 * (d0 + d1), t = 0.5 * (soft.x + soft.y);
        if (density > 0.0) {
            Sample s = between(a.s, b.s, t);
            s.density = clamp(mix(a.unclamped, b.unclamped, t), 0.0, BELOW_ONE);
            look_from_middle_to(mix(part.x, part.y, t), path);
            if (density < 1.0) s.shading = shading_normal(s, density, path);
            float alpha = segment_opacity(d0, d1, amount * (soft.y - soft.x) * extinction(s, density));
            soft_matter = vec4(medium(s, density), 1.0) * alpha;
            position_eye = middle_eye;
        }
        remember(part == vec2(0.0, 1.0) && soft == vec2(0.0, 1.0) ? density : -1.0);
    } else {
        remember(-1.0);
    }
    if (hard.y > hard.x) {
        Sample s = entering && skin > 0.0 ? under : a.s;
        float d0 = entering && skin > 0.0 ? d_under : a.density;
        float d1 = entering || skin >= 1.0 ? b.density : d_under;
        float alpha = segment_opacity(d0, d1, amount * (hard.y - hard.x));
        if (alpha > 0.0) {
            look_from_middle_to(mix(part.x, part.y, hard.x), path);
            s.normal = cap_normal(s.x, s.normal);
            hard_matter = vec4(surface(s), 1.0) * alpha;
            position_eye = middle_eye;
        }
    }
    vec4 near = entering ? soft_matter : hard_matter;
    return near + (1.0 - near.a) * (entering ? hard_matter : soft_matter);
}
