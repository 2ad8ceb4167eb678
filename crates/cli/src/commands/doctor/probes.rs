//! Self-tests for known driver faults, with the workaround of each.

use super::bench::{Bench, Outcome, ProbeError, Run};
use super::drivers;
use super::finding::Diagnosis;
use hypertexture::gpu::{Dimension, Format, Gpu, Image};
use hypertexture::shader::{self, Linker};
use std::sync::Arc;

/// A test by its name in the report.
type Test<'a> = (&'a str, &'a dyn Fn(&Bench<'_>) -> Result<Outcome, ProbeError>);

/// Runs every test; an error counts as a failure.
pub(super) fn run(gpu: &Gpu, report: &mut Diagnosis) {
    let linker = match Linker::new() {
        Ok(linker) => linker,
        Err(error) => return report.line("FAIL", &format!("{error}; reinstall the program")),
    };
    let bench = Bench { gpu, library: shader::shipped(), linker };
    let tests: [Test<'_>; 12] = [
        ("loops", &loops),
        ("filter of 4 x 8 bits", &|bench| filter(bench, Format::Rgba8Unorm)),
        ("filter of 16 bits", &|bench| filter(bench, Format::R16Unorm)),
        ("filter of 4 x 16 bits", &|bench| filter(bench, Format::Rgba16Unorm)),
        ("blending in unorm8", &|bench| blend(bench, Format::Rgba8Unorm)),
        ("blending in float16", &|bench| blend(bench, Format::Rgba16Float)),
        ("blending in float32", &|bench| blend(bench, Format::Rgba32Float)),
        ("NaN", &nan),
        ("timestamps", &timestamps),
        ("values behind loops", &drivers::crossing),
        ("derivatives", &drivers::derivatives),
        ("sines", &drivers::sines),
    ];
    for (name, test) in tests {
        let (what, finding) = test(&bench).unwrap_or_else(|error| ("FAIL", error.to_string()));
        report.line(what, &format!("{name}: {finding}"));
    }
}

/// Loops that keep a processor busy for minutes.
#[cfg(test)]
pub(super) const LOOPS: Run<'static> = Run {
    fragment: "doctor/loops.frag",
    format: Format::Rgba32Float,
    size: [2048, 2048],
    layers: 64,
    volume: None,
    setting: None,
};

/// llvmpipe ends the loops of an invocation after 65 535 iterations in total without an error.
fn loops(bench: &Bench<'_>) -> Result<Outcome, ProbeError> {
    const ASKED: usize = 70_000;
    let format = Format::Rgba32Float;
    let run = Run { fragment: "doctor/loops.frag", format, size: [1, 1], layers: 1, volume: None, setting: None };
    let [low, high, ..] = bench.draw(&run)?.0[0];
    let found = low as u32 | (high as u32) << 16;
    let states =
        std::iter::successors(Some(0u32), |state| Some(state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)));
    Ok(match states.take(ASKED + 1).position(|state| state == found) {
        Some(ASKED) => ("PASS", format!("a fragment runs {ASKED} iterations")),
        Some(steps) => (
            "NOTE",
            format!(
                "a fragment stops in silence after {steps} iterations; a scene whose rays would take more than 60000 is \
                 refused; a loop in a module of your own counts for every sample"
            ),
        ),
        None => ("FAIL", "a loop of integers gives a wrong result; update the driver".into()),
    })
}

/// Some drivers filter 8-bit texels with 8-bit arithmetic: steps instead of a slope between two close texels.
fn filter(bench: &Bench<'_>, format: Format) -> Result<Outcome, ProbeError> {
    const PLACES: u32 = 256;
    if !bench.gpu.can_filter(format) {
        return Ok(("NOTE", "the device has none".into()));
    }
    // Two texels, four codes of 8 bits apart.
    let ends = [100u32, 104].map(|code| code as f32 / 255.0);
    let texels: Vec<u8> = match format {
        Format::Rgba8Unorm => ends.iter().flat_map(|end| [(end * 255.0).round() as u8; 4]).collect(),
        Format::R16Unorm => ends.iter().flat_map(|end| code16(*end).to_ne_bytes()).collect(),
        _ => ends.iter().flat_map(|end| [code16(*end); 4]).flat_map(u16::to_ne_bytes).collect(),
    };
    let volume = Image::sampled(bench.gpu, "self-test", Dimension::Volume(2, 1, 1), format, &texels)?;
    let (fragment, size) = ("doctor/filter.frag", [PLACES, 1]);
    let run =
        Run { fragment, format: Format::Rgba32Float, size, layers: 1, volume: Some(Arc::new(volume)), setting: None };
    let found: Vec<f32> = bench.draw(&run)?.0.iter().map(|texel| texel[0]).collect();
    let mut distinct: Vec<u32> = found.iter().map(|value| value.to_bits()).collect();
    distinct.sort_unstable();
    distinct.dedup();
    let truth = |column: usize| ends[0] + (column as f32 + 0.5) / PLACES as f32 * (ends[1] - ends[0]);
    let error = found.iter().enumerate().map(|(column, value)| (value - truth(column)).abs()).fold(0.0, f32::max);
    let error = error / (ends[1] - ends[0]);
    let measured = format!("{} values at {PLACES} places of a cell, error up to {error:.4} of it", distinct.len());
    // Half of 8 fraction bits of the weight, which hardware commonly has, with as much again to spare.
    Ok(match (error < 1.0 / 256.0 + 1e-4, format) {
        (true, _) => ("PASS", measured),
        (false, Format::Rgba8Unorm) => (
            "NOTE",
            format!(
                "{measured}; volumes have 16 bits unless --field-encoding normals8 asks otherwise, which shows terraces here"
            ),
        ),
        (false, _) => ("NOTE", format!("{measured}; --field-encoding distance32 filters in float")),
    })
}

fn code16(value: f32) -> u16 {
    (value * 65535.0).round() as u16
}

/// Layers, and their exact sum: optical depth 2.
const LAYERS: u32 = 1024;
const TRUTH: f32 = 0.864_664_7;

/// A target of few bits drops values below half its last bit.
fn blend(bench: &Bench<'_>, format: Format) -> Result<Outcome, ProbeError> {
    if !bench.gpu.can_blend(format) {
        return Ok(("NOTE", "the device has none".into()));
    }
    let run = Run { fragment: "doctor/blend.frag", format, size: [4, 4], layers: LAYERS, volume: None, setting: None };
    let found = bench.draw(&run)?.0[0][3];
    let measured = format!("{LAYERS} thin layers add up to {found:.6}, the truth is {TRUTH:.6}");
    Ok(match ((found - TRUTH).abs() < 1e-4, format) {
        (true, _) => ("PASS", measured),
        (false, Format::Rgba32Float) => ("FAIL", format!("{measured}; update the driver")),
        (false, _) => ("NOTE", format!("{measured}; the default target is float32")),
    })
}

/// Compilers may fold NaN, so that a shader cannot detect it.
fn nan(bench: &Bench<'_>) -> Result<Outcome, ProbeError> {
    let format = Format::Rgba32Float;
    let run = Run { fragment: "doctor/nan.frag", format, size: [1, 1], layers: 1, volume: None, setting: None };
    let found = bench.draw(&run)?.0[0];
    let named = ["0 / 0", "inf - inf", "NaN * 0"].iter().zip(found);
    let folded: Vec<&str> = named.filter(|(_, survives)| *survives == 0.0).map(|(name, _)| *name).collect();
    Ok(if folded.is_empty() {
        ("PASS", "0 / 0, inf - inf and NaN * 0 are NaN in a shader".into())
    } else {
        (
            "NOTE",
            format!(
                "{} give a number in a shader; modules guard their inputs, and every picture is checked outside",
                folded.join(", ")
            ),
        )
    })
}

/// Timestamps against the wall clock, for a long submission.
fn timestamps(bench: &Bench<'_>) -> Result<Outcome, ProbeError> {
    if bench.gpu.info().timestamp_period == 0.0 {
        return Ok(("NOTE", "the queue has none; times are those of the wall clock".into()));
    }
    let (fragment, format) = ("doctor/blend.frag", Format::Rgba32Float);
    let run = Run { fragment, format, size: [128, 128], layers: LAYERS, volume: None, setting: None };
    let took = bench.draw(&run)?.1;
    let measured = format!("{:.2} ms on the device, {:.2} ms by the wall clock", took.gpu_ms, took.wall_ms);
    // Starting and waiting cost the wall clock up to a few milliseconds; the device cannot take longer.
    let plausible = took.gpu_ms > 0.0 && took.gpu_ms < 1.05 * took.wall_ms && took.wall_ms < 2.0 * took.gpu_ms + 10.0;
    Ok(if plausible {
        ("PASS", measured)
    } else {
        ("NOTE", format!("{measured}; trust `in all` of a summary, not `on the device`"))
    })
}
