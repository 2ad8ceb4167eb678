// Depths at which a ray from `from` along `along`, per unit of depth, enters and leaves the box around the soft region.
// Source: PH 3.1, after Kay and Kajiya 1986.
// Object space. A ray in the plane of a face gives infinities or NaN, which min and max drop.
vec2 intersect_box(vec3 from, vec3 along) {
    vec3 safe = mix(along, vec3(1e-20), lessThan(abs(along), vec3(1e-20)));
    vec3 a = (box_min.xyz - sample_reach - from) / safe, b = (box_max.xyz + sample_reach - from) / safe;
    vec3 near = min(a, b), far = max(a, b);
    return vec2(max(near.x, max(near.y, near.z)), min(far.x, min(far.y, far.z)));
}

// The same of the ball around the soft region: a ball and a box leave out different corners of each other. Where the
// ray misses the ball, it leaves before it enters.
vec2 ball_crossing(vec3 from, vec3 along) {
    float length2 = dot(along, along), nearest = -dot(from, along) / length2;
    vec3 closest = from + nearest * along;
    float radius = soft_radius + sample_reach, left2 = radius * radius - dot(closest, closest);
    float half_chord = left2 > 0.0 ? sqrt(left2 / length2) : -1.0;
    return vec2(nearest - half_chord, nearest + half_chord);
}
