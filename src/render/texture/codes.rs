//! Integer codes of numbers in [0, 1].

/// Nearest code of a number, clamped to \[0, 1\]. Truncates, since `round` is a function call for each texel.
pub(super) fn code16(part: f32) -> u16 {
    (part * 65535.0 + 0.5) as u16
}

pub(super) fn code8(part: f32) -> u8 {
    (part * 255.0 + 0.5) as u8
}
