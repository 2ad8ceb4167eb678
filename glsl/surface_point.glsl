// What every object module returns.
// Source: MJ 3.1.
// distance: signed, positive outside, object units; normal: gradient of the distance, object space, not normalized.
struct Surface {
    float distance;
    vec3 normal;
};
