#version 450
// How much light four segments of a ray from the light let through: four texels of the shadow volume before the products
// along the rays are taken. The matter is that of the picture, by the modules of the scene.
// Source: PH 4 and MJ 7 (shadows by preprocessing); PH 3.1 (opacity of a segment).
// A square of rays for each four distances, side by side. Result: transmittances in [0, 1], in order of the distance.
#include "interface.glsl"
#include "vector.glsl"
#define ONE_SAMPLE
#define OPACITY_ALONE          // a volume that is kept depends on no color
#include "light_space.glsl"
#include "trace.glsl"
vec3 position_eye;                      // eye space
const bool follows = false;             // no sample of the ray was taken before this one
vec4 color = vec4(1.0);

// The eye is the light.
vec3 to_eye() { return safe_normalize(light_position.xyz - position_eye, vec3(0.0, 0.0, 1.0)); }
// A sample is as wide as a step of this ray, or of those of the picture.
float path_scale() { return 1.0; }
float pixel_width() { return (shadow_far - shadow_near) / (shadow_side * shadow_steps); }
#include <clip>
#include <classify>
#include <empty_space>
#include <cells>

// Goes to a sample by its place along the ray; result: whether it is in the box, and not cut away. x: object space.
bool sample_at(vec2 ray, float along, out vec3 x) {
    position_eye = from_light_space(vec3(ray, along / shadow_side));
    x = (texture_matrix * vec4(position_eye, 1.0)).xyz;
    return all(greaterThanEqual(x, box_min.xyz)) && all(lessThanEqual(x, box_max.xyz)) && !clipped(x);
}

// Steps over cells that are empty, from the sample of this number.
float over_cells(vec3 x, float path, float i) { return empty_steps(x, mat3(texture_matrix) * (-path * to_eye()), i); }

float to_next(float path) { return advance(path * length(mat3(texture_matrix) * to_eye())); }

void trace() {
    float columns = ceil(sqrt(ceil(shadow_side / 4.0)));
    vec2 square = floor(pixel_center / shadow_side);
    vec2 ray = pixel_center / shadow_side - square;
    float first = 4.0 * (square.y * columns + square.x);
    float path = (shadow_far - shadow_near) / (shadow_side * shadow_steps);
    float samples = first < shadow_side ? 4.0 * shadow_steps : 0.0;
    fragment = vec4(1.0);
    float next = 1.0;
    for (float i = 0.0; i < samples; i += next) {
        vec3 x = vec3(0.0);
#if defined(TWO_PHASES) && defined(FINDS)
        float density = 0.0;
        for (; i < samples; i += next) {                // as in march.frag
            next = 1.0;
            if (!sample_at(ray, first + (i + 0.5) / shadow_steps, x)) continue;
            next = over_cells(x, path, i);
            if (next > 0.0) continue;
            density = find_density(x);
            if (density > 0.0 && (density < 1.0 || begins(x, path))) break;
            next = to_next(path);
        }
        if (i >= samples) break;
        next = 1.0;
        float alpha = matter_at(x, path, density >= 1.0).a;
#else
        next = 1.0;
        if (!sample_at(ray, first + (i + 0.5) / shadow_steps, x)) continue;
        next = over_cells(x, path, i);
        if (next > 0.0) continue;
        float alpha = classify(x, path).a;
        next = to_next(path);
#endif
        int segment = int(i / shadow_steps);
        fragment[segment] *= 1.0 - clamp(alpha, 0.0, 1.0);
        if (fragment[segment] <= 0.0) break;            // what is behind is dark whatever it is
    }
}
