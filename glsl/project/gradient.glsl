// The foot of a point on the inner surface, along the normal there by the distance there.
// Source: PH 2.4 (perpendicularly down to the inner boundary); MJ 6. Exact where the normal is: not on coarse fields,
// and not where the nearest surface changes sides.
// x: object space; s: the sample that x was displaced from; result: object space.
// @needs normal
float coherence_of_foot = 1.0;

vec3 project(vec3 x, Sample s) {
    Sample at = sample_object(x);
    coherence_of_foot = at.coherence;
    return x - (at.distance - iso_value) * at.normal;
}

// How far the foot found last is to be trusted, in [0, 1]: across a medial axis it jumps through a blur of both sides.
float trust(Sample s) { return smoothstep(0.35, 0.85, coherence_of_foot); }
