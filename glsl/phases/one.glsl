// One phase: noise drifts on without end.
// Source: -
// SECOND_PHASE: code for the noise of one loop before; UNTIL: sum from which on turbulence may end.
#define SECOND_PHASE(code)
#define UNTIL(enough) enough
