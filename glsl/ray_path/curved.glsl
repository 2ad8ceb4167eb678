// Light on a curve where the index changes smoothly: d/ds (n dr/ds) = grad n.
// Source: the step of Runge, Kutta and Nystroem in Sharma, Kumar and Ghatak 1982, of order 4, three gradients each.
// path: a step within the medium of the ray, object units; result: the ray at its end.
vec3 bend(vec3 at, Index medium) { return mat3(normal_matrix) * pull(object_space(at), medium); }

Ray moved(Ray ray, float path) {
    if (ray.medium.slope == 0.0) {
        ray.at += path * ray.along;
        return ray;
    }
    float h = path / ray.medium.value;
    vec3 t = ray.medium.value * ray.along;
    vec3 a = h * bend(ray.at, ray.medium);
    vec3 b = h * bend(ray.at + h * (0.5 * t + 0.125 * a), ray.medium);
    vec3 c = h * bend(ray.at + h * (t + 0.5 * b), ray.medium);
    ray.bent = ray.at += h * (t + (a + 2.0 * b) / 6.0);
    ray.along = safe_normalize(t + (a + 4.0 * b + c) / 6.0, ray.along);
    return ray;
}
