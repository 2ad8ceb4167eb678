//! Codes of parts in [0, 1].

/// The nearest code to a part in \[0, 1\]; others are held. By cutting off, as `round` is a call for each texel.
pub(super) fn code16(part: f32) -> u16 {
    (part * 65535.0 + 0.5) as u16
}

pub(super) fn code8(part: f32) -> u8 {
    (part * 255.0 + 0.5) as u8
}
