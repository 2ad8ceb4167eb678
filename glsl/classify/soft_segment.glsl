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

float modulated(inout Sample s) { return s.density > 0.0 ? clamp(modulate(s.density, s), 0.0, 1.0) : 0.0; }

End end_at(vec3 x) {
    Sample s = sample_object(x);
    float density = modulated(s);
    return End(s, soften_unclamped(s.distance), density);
}

// What is seen of two ends: the sample at part t of the way, on a line.
Sample between(Sample a, Sample b, float t) {
    Sample s = a;
    s.x = mix(a.x, b.x, t);
    s.distance = mix(a.distance, b.distance, t);
    s.normal = safe_normalize(mix(a.normal, b.normal, t), a.normal);
    s.shading = s.normal;
    s.coherence = mix(a.coherence, b.coherence, t);
    s.hair_normal = safe_normalize(mix(a.hair_normal, b.hair_normal, t), a.hair_normal);
    s.hair_tangent = safe_normalize(mix(a.hair_tangent, b.hair_tangent, t), a.hair_tangent);
    return s;
}

vec4 classify(vec3 x, float path) {
    vec3 along = to_far_end(path), from = x - 0.5 * along;
    End a = far_end;
    if (!follows) a = end_at(from);
    End b = end_at(from + along);
    far_end = b;
    distance_bound = b.s.distance_bound;
    vec2 part = kept(from, along);
#ifndef UNCUT
    if (part.x > 0.0) a = end_at(from + part.x * along);
    if (part.y < 1.0) b = end_at(from + part.y * along);
#endif
    float amount = opacity_rate * path * (part.y - part.x);
    vec3 middle_eye = position_eye;
    if (part.x > part.y || max(a.unclamped, b.unclamped) <= 0.0) {
        remember(0.0);
        return vec4(0.0);
    }
    // Where the hard and the soft region begin and end, from 0 at a to 1 at b.
    bool entering = b.unclamped > a.unclamped;
    float skin = place_of(1.0, a.unclamped, b.unclamped);
    float edge = place_of(0.0, a.unclamped, b.unclamped);
    vec2 soft = entering ? vec2(edge, skin) : vec2(skin, edge);
    vec2 hard = entering ? vec2(skin, 1.0) : vec2(0.0, skin);

    // The densities on both sides of the skin, where it lies within the segment.
    Sample at_skin = entering ? b.s : a.s;
    if (skin > 0.0 && skin < 1.0) at_skin = sample_object(from + mix(part.x, part.y, skin) * along);
    Sample under = at_skin, over = at_skin;
    under.density = 1.0;
    over.density = BELOW_ONE;
    bool within = hard.y > hard.x && soft.y > soft.x;
    float d_over = within ? modulated(over) : 0.0;
    float d_under = within ? modulated(under) : 0.0;

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
