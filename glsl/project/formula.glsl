// The foot of a point on the inner surface of an object that is a formula, exactly.
// Source: PH 2.4 (the projection computed analytically, since the geometry is well understood).
// x: object space; s: the sample that x was displaced from; result: object space.
// @needs normal
vec3 project(vec3 x, Sample s) {
    vec3 displaced = x;
    mat3 jacobian = mat3(1.0);
    displace(displaced, jacobian);
    Surface surface = object(displaced);
    return x - (surface.distance - iso_value) * surface.normal;
}

// How far the foot is to be trusted, in [0, 1].
float trust(Sample s) { return 1.0; }
