// Lookups between texels by the shader: eight in a volume or block, with weights of 32 bits.
// Source: ours. Most GPUs filter by weights of 8 bits: a distance is off by up to a 512th of a texel, and what is steep in
// a lookup, such as veins or hairs, by much more.
// lookup_volume: clamps; lookup_block: goes on as its sampler says, and its sides are powers of two, so that the center of a
// texel is a number of f32, where no neighbor has any weight; lookup_line and lookup_plane: of tables, which clamp, by two
// and four lookups. p: 1 across the image; level: from 0, between two levels both are read. Results: a filtered texel.
vec3 texel_below(vec3 p, vec3 size) { return floor(p * size - 0.5); }
vec3 texel_weight(vec3 p, vec3 size) { return p * size - 0.5 - texel_below(p, size); }

vec4 blend_texels(vec3 w, vec4 a, vec4 b, vec4 c, vec4 d, vec4 e, vec4 f, vec4 g, vec4 h) {
    return mix(mix(mix(a, b, w.x), mix(c, d, w.x), w.y), mix(mix(e, f, w.x), mix(g, h, w.x), w.y), w.z);
}

// Of eight texels: `one` is a lookup by the steps from the texel below.
#define blend_eight(one, image, p, size, level)                                                                        \
    blend_texels(texel_weight(p, size), one(image, p, size, level, vec3(0.0, 0.0, 0.0)),                               \
                 one(image, p, size, level, vec3(1.0, 0.0, 0.0)), one(image, p, size, level, vec3(0.0, 1.0, 0.0)),     \
                 one(image, p, size, level, vec3(1.0, 1.0, 0.0)), one(image, p, size, level, vec3(0.0, 0.0, 1.0)),     \
                 one(image, p, size, level, vec3(1.0, 0.0, 1.0)), one(image, p, size, level, vec3(0.0, 1.0, 1.0)),     \
                 one(image, p, size, level, vec3(1.0, 1.0, 1.0)))
#define volume_texel_at(image, p, size, level, step)                                                                   \
    texelFetch(image, ivec3(clamp(texel_below(p, size) + step, vec3(0.0), (size) - 1.0)), 0)
#define block_texel_at(image, p, size, level, step)                                                                    \
    textureLod(image, (texel_below(p, size) + step + 0.5) / (size), level)
#define lookup_volume(image, p) blend_eight(volume_texel_at, image, p, vec3(textureSize(image, 0)), 0.0)
#define lookup_level(image, p, level)                                                                                  \
    blend_eight(block_texel_at, image, p, exp2(-(level)) * vec3(textureSize(image, 0)), level)
#define lookup_block(image, p, level)                                                                                  \
    ((level) <= 0.0 ? lookup_level(image, p, 0.0)                                                                      \
                    : mix(lookup_level(image, p, floor(level)), lookup_level(image, p, floor(level) + 1.0),            \
                          fract(level)))

vec4 blend_four(vec2 w, vec4 a, vec4 b, vec4 c, vec4 d) { return mix(mix(a, b, w.x), mix(c, d, w.x), w.y); }
#define line_place(image, p) ((p) * float(textureSize(image, 0)) - 0.5)
#define line_texel(image, p, step)                                                                                     \
    texelFetch(image, clamp(int(floor(line_place(image, p))) + step, 0, textureSize(image, 0) - 1), 0)
#define lookup_line(image, p)                                                                                          \
    mix(line_texel(image, p, 0), line_texel(image, p, 1), line_place(image, p) - floor(line_place(image, p)))
#define plane_place(image, p) ((p) * vec2(textureSize(image, 0)) - 0.5)
#define plane_texel(image, p, step)                                                                                    \
    texelFetch(image, clamp(ivec2(floor(plane_place(image, p))) + step, ivec2(0), textureSize(image, 0) - 1), 0)
#define lookup_plane(image, p)                                                                                         \
    blend_four(plane_place(image, p) - floor(plane_place(image, p)), plane_texel(image, p, ivec2(0, 0)),               \
               plane_texel(image, p, ivec2(1, 0)), plane_texel(image, p, ivec2(0, 1)), plane_texel(image, p, ivec2(1, 1)))
