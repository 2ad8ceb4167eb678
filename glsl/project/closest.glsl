// The foot of a point on the inner surface, from a volume of closest points.
// Source: PH 4 (project() for empirical shapes by O(n^3) preprocessing); the way to read between voxels is ours.
// x: object space; s: the sample that x was displaced from; result: object space.
// The filter of a device would mix the two sides of a medial axis. Here each of the eight voxels says where the foot of
// x would be if the surface were flat at its own foot; the nearest one wins, and those that agree with it are mixed.
#include <storage>

// The way from a place to its foot, as the voxel of a texel has it; `apart`: from there to the place, in voxels.
vec3 way_to_foot(ivec3 texel, vec3 apart, vec3 normal) {
    vec3 stored = (2.0 * texelFetch(closest_volume, texel, 0).xyz - 1.0) * closest_range;
    float far = length(stored);
    // Nearer to the surface than some codes of the texel, the way has no direction.
    vec3 down = far > closest_range / 1024.0 ? stored / far : normal;
    return down * (far - dot(down, apart * volume_texel.xyz / volume_scale.xyz));
}

vec3 nearer(vec3 a, vec3 b) { return dot(b, b) < dot(a, a) ? b : a; }

// Ways that end within a voxel of the nearest one's end count in full, beyond two and a half voxels not at all: less, and
// the voxels show where the surface bends; more, and hairs of both sides are mixed.
vec4 vote(vec3 way, vec3 best, float weight, float voxel) {
    float agreed = (weight + 1e-4) * (1.0 - smoothstep(voxel, 2.5 * voxel, distance(way, best)));
    return vec4(way, 1.0) * agreed;
}

vec3 project(vec3 x, Sample s) {
    vec3 displaced = x;
    mat3 jacobian = mat3(1.0);
    displace(displaced, jacobian);
    vec3 at = (volume_scale.xyz * displaced + volume_offset.xyz) / volume_texel.xyz - 0.5;      // in voxels
    vec3 last = round(1.0 / volume_texel.xyz) - 1.0;
    vec3 low = clamp(floor(at), vec3(0.0), max(last - 1.0, 0.0)), high = min(low + 1.0, last);
    vec3 u = at - low, v = u - (high - low);
    ivec3 shift = texel_shift(ivec3(low)), a = ivec3(low) + shift, b = ivec3(high) + shift;
    vec3 c0 = way_to_foot(a, u, s.normal);
    vec3 c1 = way_to_foot(ivec3(b.x, a.y, a.z), vec3(v.x, u.y, u.z), s.normal);
    vec3 c2 = way_to_foot(ivec3(a.x, b.y, a.z), vec3(u.x, v.y, u.z), s.normal);
    vec3 c3 = way_to_foot(ivec3(b.x, b.y, a.z), vec3(v.x, v.y, u.z), s.normal);
    vec3 c4 = way_to_foot(ivec3(a.x, a.y, b.z), vec3(u.x, u.y, v.z), s.normal);
    vec3 c5 = way_to_foot(ivec3(b.x, a.y, b.z), vec3(v.x, u.y, v.z), s.normal);
    vec3 c6 = way_to_foot(ivec3(a.x, b.y, b.z), vec3(u.x, v.y, v.z), s.normal);
    vec3 c7 = way_to_foot(b, v, s.normal);
    vec3 best = nearer(nearer(nearer(c0, c1), nearer(c2, c3)), nearer(nearer(c4, c5), nearer(c6, c7)));
    vec3 r = clamp(u, 0.0, 1.0), l = 1.0 - r;
    vec3 sides = volume_texel.xyz / volume_scale.xyz;
    float voxel = max(sides.x, max(sides.y, sides.z));
    vec4 sum = vote(c0, best, l.x * l.y * l.z, voxel) + vote(c1, best, r.x * l.y * l.z, voxel)
             + vote(c2, best, l.x * r.y * l.z, voxel) + vote(c3, best, r.x * r.y * l.z, voxel)
             + vote(c4, best, l.x * l.y * r.z, voxel) + vote(c5, best, r.x * l.y * r.z, voxel)
             + vote(c6, best, l.x * r.y * r.z, voxel) + vote(c7, best, r.x * r.y * r.z, voxel);
    return x + sum.xyz / sum.w;
}

// How far the foot is to be trusted, in [0, 1].
float trust(Sample s) { return 1.0; }
