// How many octaves a sum has: a constant of the pipeline.
// Source: PH 2.3.
// 1 to 10: effect.octaves. A file of its own, since every object of a scene has the same.
layout(constant_id = 0) const int OCTAVES = 8;
