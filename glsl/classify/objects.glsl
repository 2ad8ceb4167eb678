// Several objects, each with its own effect, made one by soft booleans.
// Source: PH 2.2, MJ 7 (complex volumetric scenes).
// The linker writes classify(x, path) from the formula of the scene; result premultiplied linear RGBA.
#include "distance_bound.glsl"
#include "entered_objects.glsl"
#include <boolean>
#include <opacity>
#include <objects>
