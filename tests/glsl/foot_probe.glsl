// Where the soft region is first met, and its foot.
#include "sample.glsl"
#include <project>
vec4 classify(vec3 x, float path) {
    Sample s = sample_object(x);
    if (s.density <= 0.0 || s.density >= 1.0) return vec4(0.0);
    return vec4(WHAT, 1.0);
}
