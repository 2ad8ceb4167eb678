// Lookups between texels by the sampler of the device: one for each, whose weights have 8 bits on most GPUs.
// Source: MJ 3.1, 4.1.
// lookup_volume: clamps; lookup_block: goes on as its sampler says, and its sides are powers of two; lookup_line and
// lookup_plane: of tables, which clamp. p: 1 across the image; level: from 0, between two levels both are read. Results: a
// filtered texel.
#define lookup_volume(image, p) textureLod(image, p, 0.0)
#define lookup_block(image, p, level) textureLod(image, p, level)
#define lookup_line(image, p) textureLod(image, p, 0.0)
#define lookup_plane(image, p) textureLod(image, p, 0.0)
