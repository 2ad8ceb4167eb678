//! Writer of NIfTI.
//!
//! Invariant: the sform holds the steps bit for bit; a qform is written only if it is equivalent.

use super::values::write_values;
use crate::shape::axes::{directions, lengths};
use crate::shape::{Content, Volume};
use crate::volume::nifti::header::{HeaderLayout, NIFTI1, NIFTI2, SIGNED_DISTANCE};
use glam::{DMat3, DQuat};
use std::io::{self, Write};

/// Tolerance of each dot product of perpendicular unit vectors: f32 rounding.
const ROUNDING: f64 = 1e-6;

struct HeaderBytes {
    bytes: Vec<u8>,
    layout: &'static HeaderLayout,
}

impl HeaderBytes {
    /// Writes integers of `width` bytes.
    fn integers(&mut self, at: usize, width: usize, numbers: &[i64]) {
        for (own, number) in self.bytes[at..].chunks_exact_mut(width).zip(numbers) {
            own.copy_from_slice(&number.to_le_bytes()[..width]);
        }
    }

    /// Writes floats.
    fn numbers(&mut self, at: usize, numbers: &[f64]) {
        let bits = |number: &f64| {
            if self.layout.is_wide { number.to_bits() as i64 } else { i64::from((*number as f32).to_bits()) }
        };
        let bits: Vec<i64> = numbers.iter().map(bits).collect();
        self.integers(at, self.layout.widths().0, &bits);
    }

    fn text(&mut self, at: usize, text: &[u8]) {
        self.bytes[at..][..text.len()].copy_from_slice(text);
    }
}

/// Writes a volume whose number of values has been checked.
pub(crate) fn write(volume: &Volume, to: &mut dyn Write) -> io::Result<()> {
    let [x, y, z] = volume.size.map(i64::from);
    let is_wide = x.max(y).max(z) > i64::from(i16::MAX);
    let layout = if is_wide { &NIFTI2 } else { &NIFTI1 };
    // 4 zeros after the header mean no extensions.
    let mut header = HeaderBytes { bytes: vec![0; layout.bytes + 4], layout };
    let (number, size, code) = layout.widths();
    header.integers(0, 4, &[layout.bytes as i64]);
    header.text(layout.magic, layout.single);
    header.integers(layout.dim, size, &[3, x, y, z, 1, 1, 1, 1]);
    header.integers(layout.datatype, 2, &[16]);
    header.integers(layout.bitpix, 2, &[32]);
    let data = header.bytes.len();
    if is_wide {
        header.integers(layout.offset, 8, &[data as i64])
    } else {
        header.numbers(layout.offset, &[data as f64])
    }
    header.numbers(layout.scale, &[1.0, 0.0]);
    if volume.content == Content::SignedDistance {
        header.text(layout.description, SIGNED_DISTANCE);
        header.text(layout.intent, b"signed distance");
    }
    let (origin, steps) = (volume.origin.as_dvec3(), volume.steps.as_dmat3());
    let turn = turn(&steps);
    let side = turn.map_or(1.0, |(side, _)| side);
    header.numbers(layout.pixdim, &[&[side][..], &lengths(&steps).to_array(), &[1.0; 4]].concat());
    header.integers(layout.codes, code, &[i64::from(turn.is_some()), 1]);
    if let Some((_, DQuat { x, y, z, .. })) = turn {
        header.numbers(layout.forms, &[x, y, z, origin.x, origin.y, origin.z]);
    }
    for row in 0..3 {
        let parts = [steps.x_axis[row], steps.y_axis[row], steps.z_axis[row], origin[row]];
        header.numbers(layout.forms + (6 + 4 * row) * number, &parts);
    }
    to.write_all(&header.bytes)?;
    write_values(volume, to)
}

/// Handedness and rotation of perpendicular steps.
fn turn(steps: &DMat3) -> Option<(f64, DQuat)> {
    let mut axes = directions(steps);
    if !(axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, ROUNDING) {
        return None;
    }
    let side = axes.determinant().signum();
    axes.z_axis *= side;
    let turn = DQuat::from_mat3(&axes).normalize();
    Some((side, if turn.w < 0.0 { -turn } else { turn }))
}
