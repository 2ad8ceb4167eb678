// The volume as a whole: a texel for each voxel.
// Source: MJ 3.1.
// tex_coord: of the whole volume; voxel: counted from 0; results: a filtered texel, and from a voxel to its texel.
#include <filter>
vec4 volume_at(vec3 tex_coord) { return lookup_volume(volume, tex_coord); }
ivec3 texel_shift(ivec3 voxel) { return ivec3(0); }
