// One of three DMFs that do not commute.
// Source: PH 2: H = f2(f1(f0(D))).
// density: in [0, 1]; result in [0, 1.3].
float halve(float density, Sample s) { return 0.5 * density; }
