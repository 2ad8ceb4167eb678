// Where a ray entered the object between the sample before, one step nearer to the eye, and this one.
// Source: ours: the crossing of a line through both distances, and again through the distance found there: an error of
// the third order in the step. The first sample behind the surface has that of the first, which shows as terraces.
// Shares of a step are clamped for lanes that are off: an anisotropic filter looks at all four of a quad.
// s: a sample inside `level`, a distance in object units, and then that at the surface, or at the plane that cut it;
// path: of the step. What is shaded is lit where it is. A sample that stands for no step (ONE_SAMPLE) stays.
void locate(inout Sample s, float level, float path) {
#ifndef ONE_SAMPLE
    vec3 back = mat3(texture_matrix) * (to_eye() * path);
    float end = kept(s.x, back).y, far = s.distance - level;
    if (end >= 1.0 && far + skip_slack + length(back) < 0.0) return;    // no surface is within a step
    float near = sample_object(s.x + end * back).distance - level, t = end;
    if (near <= 0.0 && end >= 1.0) return;      // the ray was inside before
    if (near > 0.0) {
        t = clamp(end * far / min(far - near, -1e-20), 0.0, end);
        float gap = sample_object(s.x + t * back).distance - level;
        t = clamp(gap > 0.0 ? t * far / min(far - gap, -1e-20) : mix(t, end, gap / min(gap - near, -1e-20)), 0.0, end);
    }
    s = sample_object(s.x + t * back);
    position_eye += to_eye() * (t * path);
#endif
}
