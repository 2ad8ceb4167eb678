// What every sum of octaves knows.
// Source: PH 2.3, 3.1.
#include <bandlimit>
layout(constant_id = 0) const int OCTAVES = 8;
const float MEAN_NOISE = 0.156;         // of |noise| with weights of 2002, as measured; of 1989: 0.148
const float ALL = 2.0;                  // more than any sum
