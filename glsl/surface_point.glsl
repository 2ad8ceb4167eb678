// Result of object modules.
// Source: MJ 3.1.
// distance: signed, positive outside, object units; normal: gradient of the distance, object space, of length 1 where it is unique.
struct Surface {
    float distance;
    vec3 normal;
};
