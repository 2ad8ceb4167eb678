// One clipping plane, to see inside; the cut is shaded as a flat cap.
// Source: MJ 1 (internal object detail).
// x: object space; the side with dot(n, x) > d is removed. The cap is as thick as one and a half slices.
bool clipped(vec3 x) { return dot(clip_plane.xyz, x) > clip_plane.w; }
vec3 cap_normal(vec3 x, vec3 normal) {
    return dot(clip_plane.xyz, x) > clip_plane.w - 1.5 * step_size ? clip_plane.xyz : normal;
}
