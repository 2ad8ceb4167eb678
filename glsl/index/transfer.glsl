// Index of refraction by density, through the index map: an extra channel of the transfer map.
// Source: PH 2.4 (blue glass) and 3.1 (the gradient by differences).
// x: object space; index in [1, 4], gradients per object unit.
// @needs normal
#include "sample.glsl"
#include "distance_bound.glsl"
#include "index_point.glsl"
#include <dmf>

// Outside the soft region nothing is modulated (MJ 6).
float matter_density(inout Sample s) { return s.density > 0.0 ? clamp(modulate(s.density, s), 0.0, 1.0) : 0.0; }

// The index map at a density: linear between two entries of one layer, the nearer entry where a layer ends between them.
Index index_of(float density) {
    int size = textureSize(index_map, 0);
    float at = density * float(size - 1);
    int low = min(int(at), size - 2);
    vec3 a = texelFetch(index_map, low, 0).xyz, b = texelFetch(index_map, low + 1, 0).xyz;
    float t = at - float(low);
    if (a.z != b.z) t = step(0.5, t);
    vec3 entry = vec3(a.xy + t * (b.xy - a.xy), t < 0.5 ? a.z : b.z);
    // Where the density ends, at 0 or 1, its gradient jumps to 0: a layer ends there if the index follows the density.
    bool ends = entry.y != 0.0 && (density <= 0.0 || density >= 1.0);
    if (ends) entry = vec3(entry.x, 0.0, entry.z + (density <= 0.0 ? -0.5 : 0.5));
    return Index(entry.x, entry.y, entry.z, density);
}

float density_at(vec3 x) {
    Sample s = sample_object(x);
    return matter_density(s);
}

Index index_at(vec3 x) {
    Sample s = sample_object(x);
    distance_bound = s.distance_bound;
    float density = matter_density(s);
    if (!clipped(x)) return index_of(density);
    Index cut = index_of(0.0);
    cut.layer = -1.0;
    return cut;
}

// Gradient of the modulated density. Where no DMF has changed it, it lies along the normal of the sample, which is smooth
// where the differences of a filtered volume are not.
vec3 density_gradient(vec3 x, out vec3 bare_normal) {
    Sample s = sample_object(x);
    bool bare = matter_density(s) == s.density;
    bare_normal = bare ? s.normal : vec3(0.0);
    float h = max(0.25 * step_size, 1e-3);          // smaller: f32 and 16-bit texels show; larger: it blurs
    vec3 gradient = vec3(0.0);
    for (int axis = 0; axis < (bare ? 1 : 3); ++axis) {
        vec3 along = bare ? s.normal : vec3(axis == 0, axis == 1, axis == 2);
        gradient += along * (density_at(x + h * along) - density_at(x - h * along));
    }
    return gradient / (2.0 * h);
}

// n grad n at a point that a ray in `medium` reaches.
vec3 pull(vec3 x, Index medium) {
    vec3 bare_normal;
    Index at = index_of(density_at(x));
    return at.slope == 0.0 ? vec3(0.0) : at.value * at.slope * density_gradient(x, bare_normal);
}

// Normal of the interface between two points that are very near to each other, and that of its face there, which the other
// smooths: of any length and sign; 0 without an interface.
vec3 interface_normal(vec3 from, vec3 to, out vec3 face) {
    face = clip_plane.xyz;
    if (clipped(from) != clipped(to)) return face;
    vec3 bare_normal;
    vec3 gradient = density_gradient(from, bare_normal);
    face = gradient;
    if (bare_normal == vec3(0.0)) return gradient;
    const float h = 1e-3;                           // smaller: f32 shows; larger: it blurs
    for (int axis = 0; axis < 3; ++axis) {
        vec3 along = h * vec3(axis == 0, axis == 1, axis == 2);
        face[axis] = sample_object(from + along).distance - sample_object(from - along).distance;
    }
    return bare_normal;
}
