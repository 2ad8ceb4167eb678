// Which level of a block of summed octaves a sample reads: each level has one octave less than the one before, which has
// left its mean, in half as many texels; between two levels the filter of the sampler fades that octave.
// Source: PH 3.1 (frequency clamping), for MJ 4.1 (all octaves in one fetch); one octave fades at a time.
// width: of a sample, lattice cells of the first octave; octaves: of the block, 0 to 8; result: level, 0 to octaves.
float octave_level(float width, float octaves) {
    if (width <= 0.0) return 0.0;
    float level = 0.0, cells = width;
    for (int index = 0; index < 8; ++index) {
        level += float(index) < octaves ? 1.0 - octave_weight(cells) : 0.0;
        cells *= 2.0;
    }
    return level;
}
