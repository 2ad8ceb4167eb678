// Light goes straight between interfaces: for an index that only jumps.
// Source: PH 2.4 (rays are bent where the index differs from that of the sample before).
// path: of any length within the medium of the ray, object units; result: the ray at its end.
Ray moved(Ray ray, float path) {
    ray.at += path * ray.along;
    return ray;
}
