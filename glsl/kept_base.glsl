// How much of an effect there is above the base that a scene keeps as it is: 0 on it, then rising to 1 with an even slope.
// Source: ours.
// x: object space. Below the height own_min.w nothing changes, from own_max.w on nothing is held back.
float above_base(vec3 x) { return smoothstep(own_min.w, own_max.w, x.y); }

vec3 above_base_slope(vec3 x) {
    float part = clamp((x.y - own_min.w) / (own_max.w - own_min.w), 0.0, 1.0);
    return vec3(0.0, 6.0 * part * (1.0 - part) / (own_max.w - own_min.w), 0.0);
}
