//! Self-tests of what Vulkan leaves to drivers, or a driver gets wrong, with the way round it.

use super::bench::{Bench, Outcome, ProbeError, Run};
use hypertexture::gpu::{DeviceInfo, Format};
use std::f32::consts::PI;

/// Pixels along a side of a program's target.
const SIDE: u32 = 64;
/// Largest error of a place on the map of shadows, whose sides are 1: f32 near the pole behind the light.
const MAX_PLACE_ERROR: f64 = 6e-6;
/// Error from which on a sine is coarse: f32 has 1e-7, and Vulkan allows 5e-4.
const COARSE_SINE: f64 = 1e-5;

/// Texels of a program of `glsl/doctor`, row by row.
fn drawn(bench: &Bench<'_>, fragment: &str, setting: Option<f32>) -> Result<Vec<[f32; 4]>, ProbeError> {
    let format = Format::Rgba32Float;
    let run = Run { fragment, format, size: [SIDE; 2], layers: 1, volume: None, setting };
    Ok(bench.draw(&run)?.0)
}

/// llvmpipe of Mesa 26.1 reads values that all pixels share from one that the triangle does not cover.
pub(super) fn crossing(bench: &Bench<'_>) -> Result<Outcome, ProbeError> {
    Ok(judged_crossing(&drawn(bench, "doctor/crossing.frag", Some(1.0))?, bench.gpu.info()))
}

fn judged_crossing(texels: &[[f32; 4]], info: &DeviceInfo) -> Outcome {
    let lost = texels.iter().filter(|texel| texel[0] != 3.0).count();
    let measured = format!("a uniform that a loop reads is lost behind it in {lost} of {} pixels", texels.len());
    match (lost, info.cpu) {
        (0, _) => ("PASS", "a uniform that a loop reads is the same behind it".into()),
        (_, true) => ("NOTE", format!("{measured}; programs run in covered pixels alone, where it is right")),
        (_, false) => ("FAIL", format!("{measured}; update the driver")),
    }
}

/// Vulkan lets a device take one difference for a quad, and some miss neighbors along the edge of a triangle.
pub(super) fn derivatives(bench: &Bench<'_>) -> Result<Outcome, ProbeError> {
    Ok(judged_derivatives(&drawn(bench, "doctor/derivatives.frag", None)?, bench.gpu.info()))
}

fn judged_derivatives(texels: &[[f32; 4]], info: &DeviceInfo) -> Outcome {
    let value = |x: u32, y: u32| ((5 * x + 3 * y) % 7) as f32;
    let (mut coarse, mut wrong) = (0, 0);
    for (index, [across, down, fine_across, fine_down]) in (0u32..).zip(texels.iter().copied()) {
        let (x, y) = (index % SIDE, index / SIDE);
        let truth = [value(x | 1, y) - value(x & !1, y), value(x, y | 1) - value(x, y & !1)];
        coarse += u32::from([across, down] != truth);
        wrong += u32::from([fine_across, fine_down] != truth);
    }
    let measured = format!("wrong in {wrong} of {} pixels, as along the edge of a triangle", texels.len());
    match (wrong, coarse) {
        (0, 0) => ("PASS", "dFdx and dFdy take the difference of each row and column of a quad".into()),
        (0, _) => ("NOTE", "dFdx and dFdy take one difference for a quad; bent rays ask for fine ones".into()),
        _ if info.computes && info.misses_neighbors() => {
            ("NOTE", format!("{measured}; compute shaders draw bent rays"))
        }
        _ => ("FAIL", format!("{measured}; update the driver, or draw bent rays by --stage compute")),
    }
}

/// Vulkan leaves sin, cos and atan errors that would move shadows from driver to driver.
pub(super) fn sines(bench: &Bench<'_>) -> Result<Outcome, ProbeError> {
    Ok(judged_sines(&drawn(bench, "doctor/light_space.frag", None)?))
}

fn judged_sines(texels: &[[f32; 4]]) -> Outcome {
    let off = |found: f64, truth: f64| match (found - truth).abs() {
        error if error.is_nan() => f64::INFINITY,
        error => error,
    };
    let [mut place, mut sine, mut arc] = [0f64; 3];
    for (index, texel) in texels.iter().enumerate() {
        let angle = f64::from(PI * (index as f32 / texels.len() as f32));
        let [x, sin, cos, atan] = texel.map(f64::from);
        let own = sin.atan2(cos); // of the direction that was placed
        place = place.max(off(x, 0.5 + (own / 4.0).sin() / 2f64.sqrt()));
        sine = sine.max(off(sin, angle.sin())).max(off(cos, angle.cos()));
        arc = arc.max(off(atan, own));
    }
    let measured = format!("sin and cos are off by up to {sine:.1e}, atan by {arc:.1e}");
    match (place <= MAX_PLACE_ERROR, sine.max(arc) <= COARSE_SINE) {
        (true, true) => ("PASS", format!("{measured}, places of shadows by {place:.1e}")),
        (true, false) => (
            "NOTE",
            format!(
                "{measured}; shadows and woven cloth use none of them (places of shadows: {place:.1e}), but colors of \
                 stone, waves and wind may differ as much from those of another device"
            ),
        ),
        (false, _) => ("FAIL", format!("{measured}, places of shadows by {place:.1e}; update the driver")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: usize = (SIDE * SIDE) as usize;

    /// A device that is a CPU or not, of a driver.
    fn device(cpu: bool, driver: &str) -> DeviceInfo {
        let mut info = DeviceInfo::default();
        (info.cpu, info.computes, info.driver) = (cpu, true, driver.into());
        info
    }

    #[test]
    fn a_value_that_is_lost_behind_a_loop_is_told() {
        let mut texels = vec![[3.0, 1.0, 1.0, 1.0]; PIXELS];
        let said = |texels: &[[f32; 4]], cpu| judged_crossing(texels, &device(cpu, ""));
        assert_eq!(said(&texels, true).0, "PASS");
        texels[130][0] = 0.0;
        let (what, finding) = said(&texels, true);
        assert!(what == "NOTE" && finding.contains("1 of 4096 pixels; programs run in covered"), "{finding}");
        assert_eq!(said(&texels, false).0, "FAIL", "a GPU has no way round");
    }

    #[test]
    fn coarse_and_missed_derivatives_are_told_apart() {
        let value = |x: u32, y: u32| ((5 * x + 3 * y) % 7) as f32;
        let across = |x: u32, y: u32| value(x | 1, y) - value(x & !1, y);
        let down = |x: u32, y: u32| value(x, y | 1) - value(x, y & !1);
        let drawn = |by_quad: bool| -> Vec<[f32; 4]> {
            let texel = |index: u32| {
                let (x, y) = (index % SIDE, index / SIDE);
                let [u, v] = if by_quad { [x & !1, y & !1] } else { [x, y] };
                [across(u, v), down(u, v), across(x, y), down(x, y)]
            };
            (0..SIDE * SIDE).map(texel).collect()
        };
        let said = |texels: &[[f32; 4]], driver: &str| judged_derivatives(texels, &device(true, driver));
        assert_eq!(said(&drawn(false), "SwiftShader driver").0, "PASS");
        let (what, finding) = said(&drawn(true), "SwiftShader driver");
        assert!(what == "NOTE" && finding.contains("one difference for a quad"), "{finding}");
        let mut missed = drawn(false);
        missed[65][3] = 9.0;
        let (what, finding) = said(&missed, "llvmpipe Mesa 26.1.6 (LLVM 19.1.7)");
        assert!(what == "NOTE" && finding.contains("compute shaders draw bent rays"), "{finding}");
        assert_eq!(said(&missed, "another driver").0, "FAIL");
    }

    #[test]
    fn coarse_sines_are_no_fault_and_misplaced_shadows_are() {
        let drawn = |sine: f32, place: f32| -> Vec<[f32; 4]> {
            let texel = |index: usize| {
                let angle = PI * (index as f32 / PIXELS as f32);
                let (sin, cos) = (angle.sin() + sine, angle.cos());
                let own = f64::from(sin).atan2(f64::from(cos));
                let x = 0.5 + (own / 4.0).sin() / 2f64.sqrt();
                [x as f32 + place, sin, cos, own as f32]
            };
            (0..PIXELS).map(texel).collect()
        };
        assert_eq!(judged_sines(&drawn(0.0, 0.0)).0, "PASS");
        let (what, finding) = judged_sines(&drawn(2e-4, 0.0));
        assert!(what == "NOTE" && finding.contains("sin and cos are off by up to 2.0e-4"), "{finding}");
        assert_eq!(judged_sines(&drawn(0.0, 2e-5)).0, "FAIL");
        assert_eq!(judged_sines(&drawn(0.0, f32::NAN)).0, "FAIL");
    }
}
