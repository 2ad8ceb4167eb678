// A ray leaps over empty samples, and finds the others before it asks what is there, where the classification has two
// phases: the picture does not change.
// Source: MJ 7 (empty-space skipping by the distance field); the two phases are ours.
// Several rays are marched together, and each waits for what another finds: where a device would cut that many turns of a
// loop, `leap` is used.
#include "empty_space/leap.glsl"
#define FINDS
