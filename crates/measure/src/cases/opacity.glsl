// Opacity of an amount setting.z, for a density of place, 2^place or 1 - 2^place where setting.w is 0, 1 or 2.
// Result: opacity of a point; of a segment to 0.37 times the density; density at its beginning and end.
#include <opacity>
void main() {
    float t = place();
    float d = setting.w == 0.0 ? t : (setting.w == 1.0 ? exp2(t) : 1.0 - exp2(t));
    float e = 0.37 * d;
    fragment = vec4(opacity(d, setting.z), segment_opacity(d, e, setting.z), d, e);
}
