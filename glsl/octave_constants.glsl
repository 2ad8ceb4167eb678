// What every sum of octaves knows.
// Source: PH 2.3, 3.1.
#include <bandlimit>
#include "octave_count.glsl"
const float MEAN_NOISE = 0.156;         // of |noise| with weights of 2002, as measured; of 1989: 0.148. src/noise.rs has it too
const float ALL = 2.0;                  // more than any sum
