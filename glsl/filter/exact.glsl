// Lookups between texels by the shader: eight for each, with weights of 32 bits.
// Source: ours. Most GPUs filter by weights of 8 bits: a distance is off by up to a 512th of a texel, and what is steep in
// a lookup, such as veins or hairs, by much more.
// lookup_volume: clamps; lookup_block: goes on as its sampler says, and its sides are powers of two, so that the center of a
// texel is a number of f32, where no neighbor has any weight. p: 1 across the image; level: from 0, between two levels
// both are read. Results: a filtered texel.
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
