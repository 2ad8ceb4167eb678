// One clipping plane, to see inside; the cut is shaded as a flat cap.
// Source: MJ 1 (internal object detail).
// x: object space; the side with dot(n, x) > d is removed. The cap is as thick as one and a half slices. A sample that
// stands for a segment is clipped when all of the segment may be; kept: the part of it that is left, as fractions.
#ifdef ONE_SAMPLE
bool clipped(vec3 x) { return dot(clip_plane.xyz, x) > clip_plane.w; }
#else
bool clipped(vec3 x) { return dot(clip_plane.xyz, x) > clip_plane.w + sample_reach; }
#endif
vec2 kept(vec3 from, vec3 along) {
    float over = dot(clip_plane.xyz, from) - clip_plane.w, rise = dot(clip_plane.xyz, along);
    if (abs(rise) < 1e-12) return over > 0.0 ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
    float t = clamp(-over / rise, 0.0, 1.0);
    return rise < 0.0 ? vec2(t, over + rise > 0.0 ? 0.0 : 1.0) : vec2(0.0, over > 0.0 ? -1.0 : t);
}
vec3 cap_normal(vec3 x, vec3 normal) {
    return dot(clip_plane.xyz, x) > clip_plane.w - 1.5 * step_size ? clip_plane.xyz : normal;
}
