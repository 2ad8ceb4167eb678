// Where a DMF acts: between two heights.
// Source: MJ 6: DMFs chosen by spatial coordinates.
// Result in [0, 1]; heights along y in object space, where the longest side of the object spans [-1, 1].
// @param height_from = 0.0 in [-4, 4]: Height at which it begins, object units.
// @param height_to = 4.0 in [-4, 4]: Height at which it ends, object units.
// @param height_blend = 0.2 in [0.001, 4]: Height over which it fades, object units.
float height(Sample s) {
    float half_blend = 0.5 * height_blend;
    return smoothstep(height_from - half_blend, height_from + half_blend, s.x.y)
         * (1.0 - smoothstep(height_to - half_blend, height_to + half_blend, s.x.y));
}
