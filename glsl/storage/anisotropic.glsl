// The volume as a whole, filtered over the footprint of a pixel: by as many samples as quality.anisotropy says.
// Source: MJ 7 (anisotropic filter). The footprint is that of the ray: derivatives between pixels are undefined in loops and
// branches, where what a driver then filters over may have no end. lavapipe of Mesa 22.3 takes some two hundred times as
// long by it, that of 25.0 less than twice.
// tex_coord: of the whole volume; voxel: counted from 0; results: a filtered texel, and from a voxel to its texel.
vec4 volume_at(vec3 tex_coord) {
    mat3 to_object = pixel_width() * mat3(place_matrix) * mat3(texture_matrix);
    vec3 across = volume_scale.xyz * (to_object * ray_basis[1]), down = volume_scale.xyz * (to_object * ray_basis[2]);
    return textureGrad(volume, clamp(tex_coord, vec3(-1.0), vec3(2.0)), across, down);  // lanes that are off may have any
}
ivec3 texel_shift(ivec3 voxel) { return ivec3(0); }
