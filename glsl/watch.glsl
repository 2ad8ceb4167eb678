// Records NaN and infinite values of a module. Evaluated, never drawn.
// Source: ours.
// module: its number, from 1 on. `fault` holds that of the first that gave such a value, and 1 for NaN or 2 for an infinity
// in f32; zeros where none did.
layout(location = 7) out vec4 fault;

void note_fault(float module, float value) {
    bool is_huge = abs(value) > 3.4028235e38;
    if (fault.x == 0.0 && (isnan(value) || is_huge)) fault = vec4(module, is_huge ? 2.0 : 1.0, 0.0, 0.0);
}
