// The volume in bricks: those that the soft region touches lie side by side in one image, and of any other there is one
// texel, in the index, that bounds the distances of the brick.
// Source: GG 39.6 (bricks; a reconstruction, the chapter is cut); the texels that two bricks share are stored in both, so
// that the filter of the device gives what it gives on the whole volume, to the rounding of a coordinate.
// tex_coord: of the whole volume; voxel: counted from 0; results: a filtered texel, and from a voxel to its texel.
#include <filter>
const float BRICK = 8.0;                // cells along a side; there is a texel more at the far end

// The brick of a place in voxels, and what the index says: its first texel and 2, or a texel in place of all.
ivec3 brick_of(vec3 at) { return clamp(ivec3(floor(at / BRICK)), ivec3(0), textureSize(brick_index, 0) - 1); }

vec4 volume_at(vec3 tex_coord) {
    vec3 at = max(tex_coord / volume_texel.xyz - 0.5, 0.0);
    ivec3 brick = brick_of(at);
    vec4 entry = texelFetch(brick_index, brick, 0);
    if (entry.a <= 1.0) return entry;
    vec3 texel = entry.xyz + min(at - BRICK * vec3(brick), BRICK) + 0.5;
    return lookup_volume(volume, texel / vec3(textureSize(volume, 0)));
}

ivec3 texel_shift(ivec3 voxel) {
    ivec3 brick = brick_of(vec3(voxel));
    vec4 entry = texelFetch(brick_index, brick, 0);
    return entry.a <= 1.0 ? -voxel : ivec3(entry.xyz) - int(BRICK) * brick;
}
