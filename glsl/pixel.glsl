// Center of the pixel of an invocation, in pixels from the corner of the picture: of a fragment, or of a compute shader.
// Source: -
#ifdef COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant) uniform Area {
    ivec2 area_first;       // pixel of the first invocation
    ivec2 area_end;         // pixels from here on are not of the area
};

// Place of a group: in strips of four, one below the other, so that those that run at a time are neighbors.
uvec2 group_place() {
    uvec2 count = gl_NumWorkGroups.xy;
    uint index = gl_WorkGroupID.y * count.x + gl_WorkGroupID.x, strip = index / (4u * count.y);
    uint within = index - strip * 4u * count.y, width = min(4u, count.x - 4u * strip);
    return uvec2(4u * strip + within % width, within / width);
}
#define pixel_center (vec2(area_first + ivec2(8u * group_place() + gl_LocalInvocationID.xy)) + 0.5)
#else
#define pixel_center gl_FragCoord.xy
#endif
