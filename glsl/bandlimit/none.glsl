// Every octave in full, whatever the samples can show.
// Source: PH 2.3.
// Results: width of a sample, 0: of a point; weight of an octave, 1.
float sample_width() { return 0.0; }
float octave_weight(float cells) { return 1.0; }
