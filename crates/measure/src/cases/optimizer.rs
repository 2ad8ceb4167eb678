//! Functions with and without spirv-opt.

use super::function::Function;
use super::lab::{CaseError, Lab, Rows};
use super::noise;
use hypertexture::shader::Linker;

/// Both agree, bit for bit where the function is `precise`.
pub(super) fn rows(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let plain = Linker::new()?.unoptimized();
    type Text = (&'static str, &'static str, &'static [(&'static str, &'static str)], [f32; 4], f64);
    let cases: [Text; 4] = [
        ("opacity, perlin", include_str!("opacity.glsl"), &[("opacity", "perlin")], [0.0, 1.0, 0.03, 0.0], 0.0),
        ("opacity, beer", include_str!("opacity.glsl"), &[("opacity", "beer")], [0.0, 1.0, 0.03, 0.0], 0.0),
        // Sums of eight corners in any order: some ulps of 1.
        ("noise", include_str!("noise.glsl"), noise::SLOTS, [-37.0, 41.0, 255.0, 0.0], 4e-6),
        ("bias", include_str!("shaping.glsl"), &[], [0.0, 1.0, 0.3, 0.0], 4e-6),
    ];
    for (what, text, slots, setting, bound) in cases {
        let optimized = Function::new(lab, text, slots)?.at(setting)?;
        let written = Function::linked(lab, &plain, text, slots)?.at(setting)?;
        let both = written.as_flattened().iter().zip(optimized.as_flattened());
        rows.worst(what, "spirv-opt", both.map(|(written, optimized)| (*written, *optimized, bound)));
    }
    Ok(())
}
