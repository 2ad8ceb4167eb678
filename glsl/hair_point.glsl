// The hair that the last density was asked of: what a DMF that grows hair leaves for the medium that lights it.
// Source: PH 4 (anisotropic fur).
// Object space, unit vectors.
vec3 hair_normal = vec3(0.0, 1.0, 0.0);     // of the skin at its root
vec3 hair_tangent = vec3(0.0, 1.0, 0.0);    // along it, towards its tip
