// Frequency clamping: an octave fades out between four and two samples a cell.
// Source: PH 3.1: stop when the period of the noise is as small as the step; faded here, so that nothing pops.
// Measured in a cloud (tests/pictures/sampling.rs): a smaller error where a step covers two cells of the first octave or more; up
// to three times as large where it covers less, since many samples of an octave average and a faded octave is gone.
// Results: width of a sample, the step along the ray or the pixel, whichever is larger, units of the object that a
// module works for, unless it is stretched; weight of an octave by the number of its cells that a sample covers, in [0, 1], continuous.
float sample_width() { return max(step_size * path_scale(), pixel_width()) / place_scale; }
float octave_weight(float cells) { return clamp(2.0 - 4.0 * cells, 0.0, 1.0); }
