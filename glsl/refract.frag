#version 450
// One ray through the picture that bends where the index of refraction changes, in samples as far apart as the slices.
// Source: PH 2.4 (blue glass: Snell's law where the index changes) and 3.1 (the normal of refraction and reflection).
// Within a layer of the index map it bends its path; at an interface Snell's law bends it once, where the crossing was
// located, and Fresnel's share of the light comes from the surroundings in the mirror. Matter on the way is lit as if it
// were looked at straight from the eye.
// Result: premultiplied linear RGBA; opaque where there are surroundings.
#include "interface.glsl"
#include "vector.glsl"
#include "index_point.glsl"
#define NEIGHBORS
#include "trace.glsl"
vec3 position_eye;                      // eye space
const bool follows = false;             // no sample of the ray was taken before this one
vec4 color = vec4(1.0);
#include <projection>
#include <clip>
#include <classify>
#include <empty_space>
#include <index>
#include <absorption>
#include <environment>
#include "box_intersection.glsl"

// The checks of a scene (scene/check.rs) count the loops with these three.
const float LONGEST_PATH = 3.0;         // in widths of the scene: a ray caught in the glass for longer is let out
const int MOST_INTERFACES = 24;         // crossed or reflected at: the same
const int HALVINGS = 14;                // of a step, to locate a crossing
const float GLASS = 0.0399;             // part of the light that glass reflects head-on; less has a weaker highlight

// Axes of the eye, origin at the object's center: lengths are true, whatever the stretch, and coordinates small.
struct Ray {
    vec3 at;
    vec3 along;     // unit
    vec3 bent;      // the last point at which it bent, or the eye: how much wider it becomes is measured from there
    Index medium;
};

vec3 object_space(vec3 at) { return mat3(texture_matrix) * at; }

#include <ray_path>

// Whether an interface lies between two points: of the map, or a density that rises within a step.
bool parted(Index a, Index b) {
    return a.layer != b.layer || (abs(a.density - b.density) > 0.5 && a.value != b.value);
}

// Part of unpolarized light that is reflected, for cosines of the angles on either side: Fresnel, exact.
float fresnel(float from, float to, float cos_from, float cos_to) {
    float s = (from * cos_from - to * cos_to) / (from * cos_from + to * cos_to);
    float p = (from * cos_to - to * cos_from) / (from * cos_to + to * cos_from);
    return 0.5 * (s * s + p * p);
}

vec4 sum = vec4(0.0);
float rest = 1.0;                       // of the light: not hidden, nor reflected away
vec3 tint = vec3(1.0);                  // of the rest: not absorbed

float pixel_angle() { return picture_scale.y * ray_scale.y; }

vec3 eye;                               // where the ray begins

// A ray is as wide at a point as if it had come there straight, however much it bends there: it is asked from where it would
// have had no width.
void add_environment(float share, vec3 at, vec3 along, float spread) {
    vec3 from = at - along * (distance(eye, at) * pixel_angle() / spread);
    vec4 seen = environment(from, along, spread);
    sum += share * vec4(tint * seen.rgb, 1.0 - (1.0 - seen.a) * dot(tint, vec3(1.0 / 3.0)));
}

// The ray meets the interface to `beyond`, `gap` ahead: it is refracted, with a reflection of the surroundings, or
// reflected as a whole.
void meet(inout Ray ray, Index beyond, float gap) {
    vec3 far = ray.at + gap * ray.along;
    vec3 g = vec3(0.0), face = vec3(0.0);
    if (beyond.value != ray.medium.value)
        g = mat3(normal_matrix) * interface_normal(object_space(ray.at), object_space(far), face);
    float size = length(g);
    if (size < 1e-6) {                  // nothing to bend at, or no side to bend to
        ray.at = far;
        ray.medium = beyond;
        return;
    }
    vec3 normal = dot(g, ray.along) > 0.0 ? -g / size : g / size;
    float eta = ray.medium.value / beyond.value;
    float cos_from = -dot(ray.along, normal);
    float k = 1.0 - eta * eta * (1.0 - cos_from * cos_from);
    vec3 mirrored = safe_normalize(ray.along + 2.0 * cos_from * normal, normal);
    if (k < 0.0) {                      // total reflection
        face = safe_normalize(mat3(normal_matrix) * face, normal);
        // A normal smoother than its face may mirror a ray back out of it, again and again.
        bool inward = dot(mirrored, face) * dot(ray.along, face) < 0.0;
        ray.along = inward ? mirrored : reflect(ray.along, face);
        ray.bent = ray.at;
        return;
    }
    float cos_to = sqrt(k);
    float reflected = fresnel(ray.medium.value, beyond.value, cos_from, cos_to);
    add_environment(rest * reflected, ray.at, mirrored, pixel_angle());
    if (eta < 1.0) {
        vec3 l = safe_normalize(light_position.xyz - object_matrix[3].xyz - ray.at, normal);
        vec3 h = safe_normalize(l - ray.along, normal);
        float specular = dot(normal, l) > 0.0 ? pow(max(dot(normal, h), 1e-6), specular_power) : 0.0;
        float head_on = (1.0 - eta) / (1.0 + eta);
        float strength = specular_strength * min(head_on * head_on / GLASS, 1.0);
        sum.rgb += rest * tint * strength * specular * light_color.rgb;
    }
    rest *= 1.0 - reflected;
    ray.along = safe_normalize(eta * ray.along + (eta * cos_from - cos_to) * normal, ray.along);
    ray.at = ray.bent = far;
    ray.medium = beyond;
}

// Whether a ray has left the box around the soft region for good.
bool gone(vec3 x, vec3 along) {
    vec3 side = vec3(greaterThan(x, box_max.xyz)) - vec3(lessThan(x, box_min.xyz));
    return any(greaterThan(side * along, vec3(0.0)));
}

// How much a direction differs most from those of the pixels beside it, in a quad. A device may take one difference for all
// of a quad unless fine ones are asked for.
#ifdef COMPUTE
shared vec3 directions[64];
float spread_of(vec3 along) {
    uint own = gl_LocalInvocationIndex;
    directions[own] = along;
    barrier();
    vec3 across = directions[own | 1u] - directions[own & ~1u], down = directions[own | 8u] - directions[own & ~8u];
    return max(length(across), length(down));
}
#else
float spread_of(vec3 along) { return max(length(dFdxFine(along)), length(dFdyFine(along))); }
#endif

void trace() {
    vec2 ndc = pixel_center * picture_scale.xy - 1.0 + picture_scale.zw;
    vec3 center_eye = object_matrix[3].xyz;
    vec3 per_depth = ray_at(ndc, 1.0) - ray_at(ndc, 0.0);
    vec2 inside = intersect_box((texture_matrix * vec4(ray_at(ndc, 0.0), 1.0)).xyz, mat3(texture_matrix) * per_depth);
    float first = max(ceil((inside.x - first_depth) / step_size), 0.0);         // PH 3.1: x = x_mu0 + k dx
    float last = min(floor((inside.y - first_depth) / step_size), slice_count - 1.0);
    Ray ray;
    ray.along = normalize(per_depth);
    ray.at = ray.bent = eye = ray_at(ndc, 0.0) - center_eye;
    bool straight = true;               // so far: then the samples are those of the planes, to the bit
    if (first <= last) {
        float before_first = first_depth + (first - 1.0) * step_size;           // an interface may lie before the first
        float k = before_first > 0.0 ? first - 1.0 : first;
        position_eye = ray_at(ndc, first_depth + k * step_size);
        ray.at = position_eye - center_eye;
        ray.medium = index_at((texture_matrix * vec4(position_eye, 1.0)).xyz);
        float spacing = step_size * path_scale();
        float travel = k < first ? spacing : 0.0;   // to the next sample
        k = first;
        float steps = 0.0;
        straight = ray.medium.slope == 0.0;
        // Loops within a loop, and little in the longest: lavapipe runs both sides of every branch, but leaves a loop.
        for (int interfaces = 0; interfaces < MOST_INTERFACES; ++interfaces) {
            Index beyond;
            bool met = false;
            for (; steps < LONGEST_PATH * slice_count; ++steps) {
                Ray ahead = moved(ray, travel);
                position_eye = straight ? ray_at(ndc, first_depth + k * step_size) : center_eye + ahead.at;
                vec3 x = straight ? (texture_matrix * vec4(position_eye, 1.0)).xyz : object_space(ahead.at);
                beyond = index_at(x);
                met = parted(ray.medium, beyond);
                if (met) break;
                tint *= transmitted(0.5 * (ray.medium.density + beyond.density) * travel);
                ray.at = straight ? position_eye - center_eye : ahead.at;
                ray.along = ahead.along;
                ray.bent = ahead.bent;
                ray.medium = beyond;
                straight = straight && beyond.slope == 0.0;
                if (gone(x, object_space(ray.along))) break;
                float next = 1.0;
                if (!clipped(x)) {
                    if (all(greaterThanEqual(x, box_min.xyz)) && all(lessThanEqual(x, box_max.xyz))) {
                        vec4 matter = classify(x, spacing);
                        sum += rest * vec4(tint, 1.0) * matter;                 // PH 3.1: front to back
                        rest *= 1.0 - matter.a;
                    }
                    next = advance(length(object_space(ray.along)) * spacing);
                }
                if (rest <= 1.0 - full_opacity) break;                          // PH 3.1: until opaque
                k += next;
                travel = next * spacing;
            }
            if (!met) break;
            float safe = 0.0, found = travel;       // the crossing lies between
            Ray near = ray;
            for (int halving = 0; halving < HALVINGS; ++halving) {
                float middle = 0.5 * (safe + found);
                Ray ahead = moved(ray, middle);
                Index there = index_at(object_space(ahead.at));
                if (parted(ray.medium, there)) {
                    found = middle;
                    beyond = there;
                } else {
                    safe = middle;
                    near = ahead;
                    near.medium = there;
                }
            }
            tint *= transmitted(0.5 * (ray.medium.density + near.medium.density) * safe);
            vec3 before = near.along;
            meet(near, beyond, found - safe);
            straight = straight && near.along == before && near.medium.slope == 0.0;
            ray = near;
            travel -= found;
        }
    }
    float spread = spread_of(ray.along);    // of a straight ray too, beside one that bends
    add_environment(rest, ray.bent, ray.along, straight ? pixel_angle() : max(spread, pixel_angle()));
    fragment = sum;
}
