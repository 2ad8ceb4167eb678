// Every sample of a ray is taken.
// Source: PH 3.1 (fixed increment).
// Result: steps to the next sample.
float advance(float step_length) { return 1.0; }
