// How deep a sample lies in the soft region: what position-dependent DMFs are faded with.
// Source: PH 2 (a DMF works in the soft region): where nothing is added at D = 0 and D = 1, no border of it shows.
// s: sample; result in [0, 1]: 0 at both ends of the soft region, 1 in its middle.
float soft_part(Sample s) { return 4.0 * s.density * (1.0 - s.density); }
