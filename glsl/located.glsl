// Whether a ray meets the object between the sample before, one step nearer to the eye, and this one; and where.
// Source: ours: see step_back.glsl. The first sample behind the surface has the error of a step, which shows as terraces.
// x: the sample; gap: its distance from the surface of `level`, object units; path: of the step; at: how far before the
// sample, in steps. A sample that stands for no step (ONE_SAMPLE) stays.
#include "step_back.glsl"

bool meets(vec3 x, float gap, float level, float path, out float at) {
    at = 0.0;
#ifdef ONE_SAMPLE
    return gap <= 0.0;
#else
    StepBack part = step_back(x, path);
    for (bool more = part.at > 0.0 || goes_on(part, gap, false); more; more = goes_on(part, gap, false)) {
        gap = sample_object(x + part.at * part.back).distance - level;
    }
    at = part.at;
    return part.met;
#endif
}

// The sample a number of steps before; shading takes place at the surface.
Sample moved_back(Sample s, float at, float path) {
#ifndef ONE_SAMPLE
    s = sample_object(s.x + at * (mat3(texture_matrix) * (to_eye() * path)));
    position_eye += to_eye() * (at * path);
#endif
    return s;
}
