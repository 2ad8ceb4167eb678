// Several objects, each with its own effect, made one by soft booleans; hard matter where the ray enters it.
// Source: PH 2.2, MJ 7 (complex volumetric scenes).
// @looks back
// The linker writes classify(x, path) from the formula of the scene; result premultiplied linear RGBA.
#include "distance_bound.glsl"
#include "step_back.glsl"
#include <boolean>
#include <opacity>

// Hard is what is dense before any DMF: a boolean of soft regions has its surface where none of its distances is 0.
float gap_of(Soft all, float size) {
    return all.density >= 1.0 ? clamp(all.distance, -0.5 * size, -1e-6) : max(all.distance, 1e-6);
}

#include <objects>
