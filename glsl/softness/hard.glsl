// No soft region: the object is closed at its iso-value.
// Source: MJ 3.5 (greater-than closes the gaps that equality would leave).
// distance: object units, positive outside; result 0 or 1. Unclamped: a ramp so steep that a line through two of its
// values crosses 1 where a line through the two distances crosses the iso-value.
float soften(float distance, float outer) { return distance <= iso_value ? 1.0 : 0.0; }
float soften(float distance) { return soften(distance, outer_iso_value); }
float soften_unclamped(float distance) { return 1.0 + (iso_value - distance) * 1e6; }
