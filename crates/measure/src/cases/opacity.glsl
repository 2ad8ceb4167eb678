// Opacity of an amount setting.z; where setting.w is 0 of densities that are the places, where it is 1 of 2 to the power of
// them, where it is 2 of those subtracted from 1.
// Result: of a point; of a segment to density 0.37 times its own; density at its beginning and end.
#include <opacity>
void main() {
    float t = place();
    float d = setting.w == 0.0 ? t : (setting.w == 1.0 ? exp2(t) : 1.0 - exp2(t));
    float e = 0.37 * d;
    fragment = vec4(opacity(d, setting.z), segment_opacity(d, e, setting.z), d, e);
}
