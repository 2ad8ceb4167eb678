// Mean of the noise along z over a period; x and y from -1/2 to 1/2 span a period.
// Source: -
// Result: 0.5 + 0.5 mean, mean square, 0.
#include <noise>
vec3 surface(Sample s) {
    vec2 sum = vec2(0.0);
    for (int k = 0; k < 64; ++k) {
        float value = noise(noise_cells * vec3(s.x.xy + 0.5, (float(k) + 0.5) / 64.0));
        sum += vec2(value, value * value);
    }
    return vec3(0.5 + sum.x / 128.0, sum.y / 64.0, 0.0);
}
