// Constants of sums of octaves.
// Source: PH 2.3, 3.1.
#include <bandlimit>
#include "octave_count.glsl"
const float ALL = 2.0;      // more than any sum
