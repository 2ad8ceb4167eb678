// Moves a fragment of a slice to where its ray is sampled; what leaves the box there is not of this object.
// Source: PH 3.1 (stochastic ray marching, jittered step phase).
// eye: eye space; x: object space; both are changed. sample_phase() is that of slot <jitter>.
#ifndef COMPUTE                         // slices alone shift their samples
void shift_sample(inout vec3 eye, inout vec3 x) {
    vec3 shift = to_eye() * (-sample_phase() * step_size * path_scale());
    eye += shift;
    x += mat3(texture_matrix) * shift;
    vec3 beyond = max(box_min.xyz - x, x - box_max.xyz);
    if (max(beyond.x, max(beyond.y, beyond.z)) > sample_reach) discard;
}
#endif
