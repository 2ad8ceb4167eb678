// The modulated density at any point: what a gradient is the gradient of.
// Source: PH 3.1 (f), MJ 6.
// x: object space; result in [0, 1].
float modulated_density(vec3 x) {
    Sample s = sample_object(x);
    return s.density > 0.0 ? clamp(modulate(s.density, s), 0.0, 1.0) : 0.0;
}

// The normal of matter whose density changes by these differences along the rays' basis (eye space, equal lengths):
// PH 3.1 turns them by the rows of that basis; an object that is stretched adds its own matrix.
vec3 normal_of(vec3 difference, vec3 otherwise) {
    vec3 gradient_eye = ray_basis * difference;
    return safe_normalize(-(gradient_eye * mat3(object_matrix)) / max(length(gradient_eye), 1e-20), otherwise);
}
