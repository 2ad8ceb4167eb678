// State of a bending ray at a point of space.
// Source: PH 2.4 (an extra channel of the color table).
struct Index {
    float value;    // index of refraction, 1 to 4
    float slope;    // not 0 where the index changes from place to place within its layer
    float layer;    // between two layers lies an interface: the index or its slope jumps there
    float density;  // in [0, 1]: what absorption goes by
};
