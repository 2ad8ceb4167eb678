//! Relations between pictures of presets, and warnings.

use super::lab::{CaseError, Lab, Rows, number, same};
use crate::statistics::{largest, rms_difference};
use hypertexture::render::variant::Variant;
use hypertexture::render::{RenderError, warnings};
use hypertexture::scene::{Effect, EmptySpace, ParameterValue, Scene, preset};
use hypertexture::shader::ParameterKind;

/// A small picture of a preset.
fn preset_of(name: &str) -> Result<Scene, CaseError> {
    let mut scene = preset(name)?;
    scene.object.input = if name == "fire_ball" { "sphere".into() } else { "torus".into() };
    (scene.image.size, scene.quality.samples) = ([48, 48], 96);
    Ok(scene)
}

/// A preset with its effect replaced by linearly soft matter.
fn soft(name: &str) -> Result<Scene, CaseError> {
    let mut scene = preset_of(name)?;
    scene.effect = Effect { classify: "soft".into(), softness: "linear".into(), ..Effect::default() };
    scene.parameters.clear();
    Ok(scene)
}

/// Skipping of empty space does not change a picture.
pub(super) fn skipping(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for name in ["lit", "bump", "fur", "melting", "fire", "fire_ball", "noisy_sphere"] {
        let scene = preset_of(name)?;
        let mut renderer = lab.renderer(&lab.subject(&scene)?);
        // The scene itself, and each parameter at both ends.
        let mut scenes = vec![(String::from("the preset"), scene.clone())];
        for (parameter, _) in scene.check(&lab.library)?.iter() {
            let ParameterKind::Number(_, ends) = parameter.kind else { continue };
            for end in ends {
                // The reach of the matter is a part of the subject.
                if parameter.name.ends_with("length") || parameter.name.ends_with("amplitude") {
                    continue;
                }
                let mut scene = scene.clone();
                scene.parameters.insert(parameter.name.clone(), ParameterValue::Number(end));
                scenes.push((format!("{} = {end}", parameter.name), scene));
            }
        }
        for (setting, scene) in scenes {
            let mut every = scene.clone();
            every.quality.empty_space = EmptySpace::Sample;
            let every = renderer.render(&every)?;
            rows.worst(format!("{name}: skipping"), setting, same(&every, &renderer.render(&scene)?, 0.0));
        }
    }
    Ok(())
}

/// A density of unbounded slope has no bound on distances, and skipping does not change its picture.
pub(super) fn steep(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for (dmf, parameter, values) in
        [("biased", "density_bias", [0.5, 0.75, 0.99]), ("gained", "density_gain", [0.5, 0.25, 0.01])]
    {
        for value in values {
            let mut scene = soft("fire_ball")?;
            scene.effect.dmf = vec![dmf.into()];
            scene.parameters.insert(parameter.into(), ParameterValue::Number(value));
            (scene.object.inner_iso, scene.object.outer_iso) = (0.0, 0.4);
            let mut renderer = lab.renderer(&lab.subject(&scene)?);
            let skipped = renderer.render(&scene)?;
            scene.quality.empty_space = EmptySpace::Sample;
            let every = renderer.render(&scene)?;
            let setting = format!("{parameter} = {value}");
            rows.worst(format!("{dmf}: skipping"), setting, same(&every, &skipped, 0.0));
        }
    }
    Ok(())
}

/// Octaves whose cells are smaller than two samples are replaced by their mean, and no longer depend on their scale.
pub(super) fn nyquist(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    const SAMPLES: u32 = 16;
    let mut plain = soft("fire_ball")?;
    (plain.effect.turbulence, plain.effect.bandlimit) = ("procedural".into(), "clamp".into());
    (plain.object.inner_iso, plain.object.outer_iso, plain.quality.samples) = (-0.5, 0.4, SAMPLES);
    plain.effect.dmf = vec!["turbulent".into()];
    let mut renderer = lab.renderer(&lab.subject(&plain)?);
    let mut at = |cells: f32| {
        plain.parameters.insert("turbulence_scale".into(), ParameterValue::Number(cells));
        renderer.render(&plain)
    };
    let nyquist = 0.5 / at(1.0)?.measurements.step;
    let all_past = at(8.0 * nyquist)?;
    for (share, setting) in [(1.01, "just past"), (2.0, "twice"), (4.0, "four times")] {
        rows.worst("octaves past Nyquist", setting, same(&all_past, &at(share * nyquist)?, 0.0));
    }
    let within = at(0.25 * nyquist)?;
    let change = largest(same(&all_past, &within, 0.0).map(|(a, b, _)| (a - b).abs()));
    rows.holds("an octave within", "a quarter", "another picture", number(change), change > 0.01);
    Ok(())
}

/// A picture repeats after whole periods of its moving noise, and changes in between.
pub(super) fn times(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    /// Period of every lattice of a block.
    const CELLS: f64 = 1024.0;
    // Effect, speed parameter, cells per second for each unit of it, and the other parameter that moves.
    let moving = [
        ("flow", "flow_speed", 1.0, ""),
        ("fire", "rise", 0.45 * 3.0, "relief_rise"),
        ("fire", "relief_rise", 2.0, "rise"),
    ];
    for (name, speed, cells, other) in moving {
        let mut scene = preset_of(name)?;
        let value = (1.0 / cells) as f32;
        scene.parameters.insert(speed.into(), ParameterValue::Number(value));
        if !other.is_empty() {
            scene.parameters.insert(other.into(), ParameterValue::Number(0.0));
        }
        let mut renderer = lab.renderer(&lab.subject(&scene)?);
        let mut at = |time: f64| {
            scene.camera.time = time;
            renderer.render(&scene)
        };
        let period = CELLS / (cells * f64::from(value));
        let start = at(0.25)?;
        for count in [1.0, 64.0, 1024.0, 16_384.0, 9e5] {
            let frame = at(0.25 + count * period)?;
            let time = format!("{:.1e} s", count * period);
            // Places resolve to 2^-12 of a cell in f32 at the end of a drift.
            let known = [(0.0, rms_difference(&start.pixels, &frame.pixels), 2e-4)];
            rows.worst(format!("{name}, {speed}: whole periods"), &time, known).at(count * period);
            let later = at(0.25 + count * period + 0.04)?;
            let change = largest(same(&frame, &later, 0.0).map(|(a, b, _)| (a - b).abs()));
            let what = format!("{name}, {speed}: a frame later");
            rows.holds(what, &time, "another picture", number(change), change > 1e-3);
        }
    }
    Ok(())
}

/// Settings that render correctly but are probably a mistake give a warning.
pub(super) fn warned(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    type Doubtful = (u32, &'static str, &'static [(&'static str, &'static str)], &'static str);
    const DOUBTFUL: [Doubtful; 7] = [
        (6, "sphere", &[("object.outer_iso", "0")], "the object is hard"),
        (7, "sphere", &[("object.inner_iso", "-1.5")], "the density is"),
        (7, "knot", &[("object.inner_iso", "-1")], "the density is"),
        (19, "sphere", &[("quality.pass", "slices"), ("quality.target", "float16")], "float32 holds it"),
        (19, "sphere", &[("quality.pass", "slices"), ("quality.target", "unorm8")], "float32 holds it"),
        (20, "knot", &[("object.field_encoding", "normals8"), ("object.outer_iso", "1")], "as steps"),
        (0, "sphere", &[], ""),
    ];
    for (case, input, changes, line) in DOUBTFUL {
        let mut scene = soft("fire")?;
        (scene.object.input, scene.object.resolution) = (input.into(), 64);
        (scene.object.inner_iso, scene.object.outer_iso, scene.image.size) = (0.0, 0.2, [16, 16]);
        for (field, value) in changes {
            scene.set_field(field, value)?;
        }
        let variant = Variant::of(&scene, &lab.library).map_err(RenderError::from)?;
        let subject = lab.subject(&variant)?;
        let frame = lab.render(&variant, &subject)?;
        let lines = warnings(&frame.measurements, &variant, &subject, &lab.library);
        let ok = if line.is_empty() { lines.is_empty() } else { lines.iter().any(|found| found.contains(line)) };
        let setting = changes.iter().map(|(field, value)| format!("{field} = {value}")).collect::<Vec<_>>().join(", ");
        let what = if case == 0 { "no warning".into() } else { format!("{input}: warning (case {case})") };
        rows.holds(&what, setting, line, lines.join("; "), ok);
    }
    Ok(())
}
