// No soft region: the object is closed at its iso-value.
// Source: MJ 3.5 (greater-than closes the gaps that equality would leave).
// distance: object units, positive outside; result 0 or 1.
float soften(float distance) { return distance <= iso_value ? 1.0 : 0.0; }
