// Small vector functions that hold where the built-in ones do not.
// Source: numerics of the project: normalize(0) is NaN.
// Any finite input; results finite.
vec3 safe_normalize(vec3 v, vec3 otherwise) {
    float n2 = dot(v, v);
    return mix(v * inversesqrt(max(n2, 1e-12)), otherwise, bvec3(n2 < 1e-12));
}
