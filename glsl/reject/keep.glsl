// A fragment without matter is blended with alpha 0, which changes nothing but the time: what a card does that goes on
// with fragments that were discarded.
// Source: MJ 7 (the FX 5900 and the way in which fragments are discarded).
// matter: premultiplied linear RGBA, alpha 0 or less; result: all 0.
void reject(inout vec4 matter) { matter = vec4(0.0); }
