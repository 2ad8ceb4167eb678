// One ray of a march: samples where the slices are, front to back.
// Source: PH 3.1; MJ 7 (fragment shader loops). The samples are those of the slice pass, so that both give one picture.
// The entry declares position_eye and says what it asks for, of sum, the matter so far, premultiplied linear RGBA:
// MEETS(matter, k) adds that of the sample k steps behind the first slice, ENDS is whether nothing behind is asked for, and
// GIVES is the result.
vec4 color = vec4(1.0);
const float CUT_SHORT = -10000.0;       // in place of what the device did not let a ray finish; see src/render/frame/prepared.rs
bool follows = false;                   // the sample taken last is one step nearer to the eye
mat3 ray_basis;                         // along the ray and to two sides, unit vectors, eye space
#include <projection>
#include <jitter>
#include <clip>
#include <classify>
#include <empty_space>
#include <cells>
#include "box_intersection.glsl"

// Goes to a sample by its number; result: where it is, object space.
vec3 sample_at(vec2 ndc, float k) {
    position_eye = ray_at(ndc, first_depth + k * step_size);
    return (texture_matrix * vec4(position_eye, 1.0)).xyz;
}

void trace() {
    vec2 ndc = pixel_center * picture_scale.xy - 1.0 + picture_scale.zw;
    vec3 from = (texture_matrix * vec4(ray_at(ndc, 0.0), 1.0)).xyz;
    vec3 along = mat3(texture_matrix) * (ray_at(ndc, 1.0) - ray_at(ndc, 0.0));
    vec2 boxed = intersect_box(from, along), round = ball_crossing(from, along);
    vec2 inside = vec2(max(boxed.x, round.x), min(boxed.y, round.y));
    float phase = sample_phase();
    float first = max(ceil((inside.x - first_depth) / step_size - phase), 0.0); // PH 3.1: x = x_mu0 + k dx
    float last = min(floor((inside.y - first_depth) / step_size - phase), slice_count - 1.0);
    vec4 sum = vec4(0.0);
    float step_length = step_size * length(along);
    float next = 1.0;
    vec3 stride = along * step_size;
    position_eye = ray_at(ndc, 1.0);
    ray_basis = ray_basis_of();
#if defined(TWO_PHASES) && defined(FINDS)
    // Loops within loops, and little in the innermost: lavapipe runs both sides of every branch, but leaves a loop. The
    // outermost is for hard matter, which most rays meet once, the next for soft matter, the innermost for empty space.
    for (float k = first; k <= last; ++k) {
        vec3 x = vec3(0.0);
        float density = 0.0;
        for (; k <= last; ++k) {
            for (; k <= last; k += next) {
                x = sample_at(ndc, k + phase);
                next = empty_steps(x, stride, k);
                if (next > 0.0 || clipped(x)) {
                    next = max(next, 1.0);
                    follows = false;
                    continue;
                }
                density = find_density(x);
                if (density > 0.0) break;
                next = advance(step_length);
                follows = next == 1.0;
            }
            if (k > last || (density >= 1.0 && begins(x, step_size * path_scale()))) break;
            follows = true;
            if (density >= 1.0) continue;
            MEETS(matter_at(x, step_size * path_scale(), false), k + phase);
            if (ENDS) last = k;
        }
        if (k > last) break;
        MEETS(matter_at(x, step_size * path_scale(), true), k + phase);
        if (ENDS) break;
        follows = true;
    }
    // After cutting a loop, a device also cuts all later ones at their second iteration, and the picture is invalid. The
    // count of this loop, 1 or 2, reveals that; it is written so that compilers cannot fold it.
    float turns = 0.0, wanted = 1.0 + step(2.0, slice_count);
    for (; turns < wanted; ++turns) {}
    if (abs(turns - wanted) > 0.5) sum = vec4(CUT_SHORT);
#else
    for (float k = first; k <= last; k += next) {
        vec3 x = sample_at(ndc, k + phase);
        next = empty_steps(x, stride, k);
        if (next > 0.0 || clipped(x)) {
            next = max(next, 1.0);
            follows = false;
            continue;
        }
        vec4 matter = classify(x, step_size * path_scale());
        next = advance(step_length);
        follows = next == 1.0;
        MEETS(matter, k + phase);
        if (ENDS) break;
    }
#endif
    fragment = vec4(GIVES);
}
