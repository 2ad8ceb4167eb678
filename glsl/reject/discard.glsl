// A fragment without matter ends at once: nothing of it is blended.
// Source: MJ 3.5 (other fragments are rejected).
// matter: premultiplied linear RGBA, alpha 0 or less; result: none.
void reject(inout vec4 matter) { discard; }
