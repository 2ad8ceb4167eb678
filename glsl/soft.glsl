// An object at a point, as the soft booleans combine it.
// Source: PH 2.2.
// Object space of the scene.
struct Soft {
    float density;      // D in [0, 1]
    vec3 slope;         // its gradient, per object unit
    float distance;     // signed, to the surface
    vec3 normal;        // unit, outward from that surface
    float distance_bound;    // no matter is nearer than this
};

// The normal to shade with: down the density where it has a slope, else away from the nearest surface.
vec3 outward(Soft a) { return dot(a.slope, a.slope) > 1e-8 ? -normalize(a.slope) : a.normal; }
