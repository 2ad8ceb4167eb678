//! Cases 4, 17, 29, 41 and 45: what must not change a picture, what must be refused by name, and what must be told.

use super::matter::same;
use super::{Lab, Row, StressError, with};
use crate::statistics::largest;
use hypertexture::render::variant::VariantError;
use hypertexture::render::{RenderError, Renderer, Subject, warnings};
use hypertexture::scene::{Effect, EmptySpace, ParameterValue, Scene, SceneError, preset};
use hypertexture::shader::ParameterKind;

fn preset_of(name: &str) -> Result<Scene, StressError> {
    let scene = preset(name).map_err(VariantError::from).map_err(RenderError::from)?;
    Ok(with(scene, |scene| {
        scene.object.input = if name == "fire_ball" { "sphere".into() } else { "torus".into() };
        (scene.image.size, scene.quality.samples) = ([48, 48], 96);
    }))
}

/// Case 41: skipping takes steps that no slope of the matter allows it to be wrong about.
pub(super) fn skipping(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let library = &lab.bench.library;
    let mut rows = Vec::new();
    for name in ["lit", "bump", "fur", "melting", "fire", "fire_ball", "noisy_sphere"] {
        let scene = preset_of(name)?;
        let own = Subject::load(&scene, library, &|_| ())?;
        let mut renderer = Renderer::new(lab.bench.gpu, library, &own);
        // At its own parameters, and with each at both ends.
        let mut scenes = vec![(String::from("its own parameters"), scene.clone())];
        for (parameter, _) in scene.check(library)?.iter() {
            let ParameterKind::Number(_, ends) = parameter.kind else { continue };
            for end in ends {
                let scene = with(scene.clone(), |scene| {
                    scene.parameters.insert(parameter.name.clone(), ParameterValue::Number(end));
                });
                // How far matter goes is a part of the subject.
                if parameter.name.ends_with("length") || parameter.name.ends_with("amplitude") {
                    continue;
                }
                scenes.push((format!("{} = {end}", parameter.name), scene));
            }
        }
        for (setting, scene) in scenes {
            let every = with(scene.clone(), |scene| scene.quality.empty_space = EmptySpace::Sample);
            let drawn = renderer.render(&every).and_then(|every| Ok((every, renderer.render(&scene)?)));
            rows.push(match drawn {
                Ok((every, skipped)) => Row::worst(&format!("{name}: skipping"), setting, same(&every, &skipped, 0.0)),
                Err(error) => Row::said(&format!("{name}: skipping"), setting, "pictures", error.to_string(), false),
            });
        }
    }
    Ok(rows)
}

/// Case 4: a density that rises without a largest slope has no distance to be trusted, and none is taken: what skips and
/// what bounds leave out is the same picture.
pub(super) fn steep(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let library = &lab.bench.library;
    let mut rows = Vec::new();
    for (dmf, parameter, values) in
        [("biased", "density_bias", [0.5, 0.75, 0.99]), ("gained", "density_gain", [0.5, 0.25, 0.01])]
    {
        for value in values {
            let mut scene = preset_of("fire_ball")?;
            scene.effect = Effect { classify: "soft".into(), softness: "linear".into(), ..Effect::default() };
            scene.effect.dmf = vec![dmf.into()];
            scene.parameters.clear();
            scene.parameters.insert(parameter.into(), ParameterValue::Number(value));
            (scene.object.inner_iso, scene.object.outer_iso) = (0.0, 0.4);
            let subject = Subject::load(&scene, library, &|_| ())?;
            let mut renderer = Renderer::new(lab.bench.gpu, library, &subject);
            let skipped = renderer.render(&scene)?;
            scene.quality.empty_space = EmptySpace::Sample;
            let every = renderer.render(&scene)?;
            let setting = format!("{parameter} = {value}");
            rows.push(Row::worst(&format!("{dmf}: what is left out"), setting, same(&every, &skipped, 0.0)));
        }
    }
    Ok(rows)
}

/// Case 29: octaves of which a sample covers half a cell are their mean, and how fine they are is not seen any more.
pub(super) fn nyquist(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    const SAMPLES: u32 = 16;
    let library = &lab.bench.library;
    let mut rows = Vec::new();
    let mut plain = preset_of("fire_ball")?;
    plain.effect = Effect { classify: "soft".into(), softness: "linear".into(), ..Effect::default() };
    (plain.effect.turbulence, plain.effect.bandlimit) = ("procedural".into(), "clamp".into());
    plain.parameters.clear();
    (plain.object.inner_iso, plain.object.outer_iso, plain.quality.samples) = (-0.5, 0.4, SAMPLES);
    plain.effect.dmf = vec!["turbulent".into()];
    let subject = Subject::load(&plain, library, &|_| ())?;
    let mut renderer = Renderer::new(lab.bench.gpu, library, &subject);
    let mut at = |cells: f32| {
        plain.parameters.insert("turbulence_scale".into(), ParameterValue::Number(cells));
        renderer.render(&plain)
    };
    let nyquist = 0.5 / at(1.0)?.measurements.step;
    let all_past = at(8.0 * nyquist)?;
    for (share, setting) in [(1.01, "just past"), (2.0, "twice"), (4.0, "four times")] {
        rows.push(Row::worst("octaves past Nyquist", setting, same(&all_past, &at(share * nyquist)?, 0.0)));
    }
    let within = at(0.25 * nyquist)?;
    let moved = largest(same(&all_past, &within, 0.0).iter().map(|(a, b, _)| (a - b).abs()));
    let found = super::report::number(moved);
    rows.push(Row::said("an octave within", "a quarter", "another picture", found, moved > 0.01));
    Ok(rows)
}

/// Case 45: after whole periods of the noise that moves through it a picture is what it was, and never stands still.
pub(super) fn times(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    /// Every lattice of a block repeats after that.
    const CELLS: f64 = 1024.0;
    // Effects that move, the parameter that says how fast, cells for each unit of it and second, and what else moves.
    let moving = [
        ("flow", "flow_speed", 1.0, ""),
        ("fire", "rise", 0.45 * 3.0, "relief_rise"),
        ("fire", "relief_rise", 2.0, "rise"),
    ];
    let library = &lab.bench.library;
    let mut rows = Vec::new();
    for (name, speed, cells, other) in moving {
        let mut scene = preset_of(name)?;
        let value = (1.0 / cells) as f32;
        scene.parameters.insert(speed.into(), ParameterValue::Number(value));
        if !other.is_empty() {
            scene.parameters.insert(other.into(), ParameterValue::Number(0.0));
        }
        let subject = Subject::load(&scene, library, &|_| ())?;
        let mut renderer = Renderer::new(lab.bench.gpu, library, &subject);
        let mut at = |time: f64| {
            scene.camera.time = time;
            renderer.render(&scene)
        };
        let period = CELLS / (cells * f64::from(value));
        let start = at(0.25)?;
        for count in [1.0, 64.0, 1024.0, 16_384.0, 9e5] {
            let frame = at(0.25 + count * period)?;
            let apart = same(&start, &frame, 0.0);
            let mean = apart.iter().map(|(a, b, _)| (a - b).powi(2)).sum::<f64>() / apart.len() as f64;
            let time = format!("{:.1e} s", count * period);
            // f32 tells places apart to 2^-12 of a cell at the end of what a drift goes through.
            let row = Row::worst(&format!("{name}, {speed}: whole periods"), &time, [(0.0, mean.sqrt(), 2e-4)]);
            rows.push(row.at(count * period));
            let later = at(0.25 + count * period + 0.04)?;
            let moved = largest(same(&frame, &later, 0.0).iter().map(|(a, b, _)| (a - b).abs()));
            let found = super::report::number(moved);
            let ok = moved > 1e-3;
            rows.push(Row::said(&format!("{name}, {speed}: a frame later"), &time, "another picture", found, ok));
        }
    }
    Ok(rows)
}

/// What nobody can draw is refused, and the line names what it is: the values of a case.
pub(super) fn refused<const CASE: u32>(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    const REFUSED: &[(u32, &str, &str)] = &[
        (17, "quality.samples", "0"),
        (17, "quality.samples", "1e9"),
        (17, "quality.samples", "nan"),
        (17, "quality.samples", "1.5"),
        (17, "quality.samples", "99000"),
        (19, "image.size", "[0, 16]"),
        (19, "image.size", "[16, 0]"),
        (19, "image.size", "[16, 4294967295]"),
        (36, "object.resolution", "2000000"),
        (36, "object.resolution", "0"),
        (8, "object.inner_iso", "0.5"),
        (8, "object.inner_iso", "nan"),
        (8, "object.outer_iso", "inf"),
        (40, "object.stretch", "[1, 0, 1]"),
        (40, "object.stretch", "[1, nan, 1]"),
        (40, "object.stretch", "[1, 1e-30, 1]"),
        (47, "effect.opacity_rate", "-1"),
        (47, "effect.opacity_rate", "inf"),
        (47, "camera.zoom", "0"),
        (47, "camera.zoom", "-1"),
        (47, "camera.field_of_view", "0"),
        (47, "camera.field_of_view", "180"),
        (47, "camera.time", "1e30"),
        (47, "camera.time", "nan"),
        (47, "light.position", "[inf, 0, 0]"),
        (47, "light.intensity", "-1"),
        (47, "material.specular_power", "nan"),
        (36, "quality.block_size", "100000"),
        (47, "quality.supersampling", "0"),
        (47, "effect.octaves", "0"),
        (47, "effect.octaves", "1000"),
    ];
    let mut rows = Vec::new();
    for (_, field, value) in REFUSED.iter().filter(|(case, ..)| *case == CASE) {
        let mut scene = preset_of("lit")?;
        let found: Result<(), SceneError> =
            scene.set_field(field, value).and_then(|()| scene.check(&lab.bench.library).map(|_| ()));
        let (found, ok) = match found {
            Ok(()) => ("accepted".to_string(), false),
            Err(error) => {
                let line = error.to_string();
                let named = line.contains(field) && !line.contains('\n');
                (line, named)
            }
        };
        rows.push(Row::said("refused", format!("{field} = {value}"), "a line that names it", found, ok));
    }
    Ok(rows)
}

/// What is right and may not be meant is told.
pub(super) fn told(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    type Doubtful = (u32, &'static str, &'static [(&'static str, &'static str)], &'static str);
    const DOUBTFUL: [Doubtful; 7] = [
        (6, "sphere", &[("object.outer_iso", "0")], "the object is hard"),
        (7, "sphere", &[("object.inner_iso", "-1.5")], "the density is"),
        (7, "knot", &[("object.inner_iso", "-1")], "the density is"),
        (43, "sphere", &[("quality.pass", "slices"), ("quality.target", "float16")], "float32 holds it"),
        (43, "sphere", &[("quality.pass", "slices"), ("quality.target", "unorm8")], "float32 holds it"),
        (20, "knot", &[("object.source", "normals8"), ("object.outer_iso", "1")], "as steps"),
        (0, "sphere", &[], ""),
    ];
    let library = &lab.bench.library;
    let mut rows = Vec::new();
    for (case, input, changes, line) in DOUBTFUL {
        let mut scene = preset_of("fire")?;
        (scene.object.input, scene.object.resolution) = (input.into(), 64);
        scene.effect = Effect { classify: "soft".into(), softness: "linear".into(), ..Effect::default() };
        scene.parameters.clear();
        (scene.object.inner_iso, scene.object.outer_iso, scene.image.size) = (0.0, 0.2, [16, 16]);
        for (field, value) in changes {
            scene.set_field(field, value)?;
        }
        let subject = Subject::load(&scene, library, &|_| ())?;
        let frame = Renderer::new(lab.bench.gpu, library, &subject).render(&scene)?;
        let lines = warnings(&frame.measurements, &scene, &subject, library).map_err(RenderError::from)?;
        let ok = if line.is_empty() { lines.is_empty() } else { lines.iter().any(|found| found.contains(line)) };
        let setting = changes.iter().map(|(field, value)| format!("{field} = {value}")).collect::<Vec<_>>().join(", ");
        let what = if case == 0 { "nothing is told".into() } else { format!("{input}: told (case {case})") };
        rows.push(Row::said(&what, setting, line, lines.join("; "), ok));
    }
    Ok(rows)
}
