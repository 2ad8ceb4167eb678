// Center of the pixel of an invocation, in pixels from the corner of the picture: of a fragment, or of a compute shader.
// Source: -
#ifdef COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant) uniform Area {
    ivec2 area_first;       // pixel of the first invocation
    ivec2 area_end;         // pixels from here on are not of the area
};
#define pixel_center (vec2(area_first + ivec2(gl_GlobalInvocationID.xy)) + 0.5)
#else
#define pixel_center gl_FragCoord.xy
#endif
