//! Truth 9, what must not change a picture, and the second half of truth 10, what thin layers add up to.

use super::analytic::Level;
use super::pictures::{SLAB, box_subject, homogeneous};
use super::{Bench, PASSES, Row, name};
use hypertexture::render::variant::VariantError;
use hypertexture::render::{Frame, RenderError, Renderer, Subject};
use hypertexture::scene::{EmptySpace, Pass, Projection, Scene, TargetFormat, preset};

/// The difference of two pictures, over all channels.
fn difference(a: &Frame, b: &Frame) -> Level {
    let channels = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let off = channels.map(|(a, b)| f64::from(a - b).abs());
    Level::of(a.measurements.slices, f64::from(a.measurements.step), off)
}

/// A soft ball, seen in perspective.
fn soft() -> Scene {
    let mut scene = homogeneous("sphere", 3.0, Projection::Perspective);
    scene.effect.softness = "quadratic".into();
    (scene.object.inner_iso, scene.object.outer_iso) = (-0.6, 0.3);
    (scene.quality.samples, scene.quality.early_termination) = (128, 0.0);
    scene
}

pub(super) fn rows(bench: &Bench<'_>) -> Result<Vec<Row>, RenderError> {
    let library = &bench.library;
    let slab = box_subject(SLAB);
    let mut rows = Vec::new();
    let ball = Subject::load(&soft(), library, &|_| ())?;
    let mut passes = Vec::new();
    for pass in PASSES {
        let mut scene = homogeneous("cube", 3.0, Projection::Perspective);
        (scene.quality.pass, scene.quality.samples) = (pass, 96);
        let mut renderer = Renderer::new(bench.gpu, library, &slab);
        let whole = renderer.render(&scene)?;
        scene.quality.samples = 192;
        let halves = renderer.render(&scene)?;
        // Where a ray goes through both faces, and not beside a corner.
        let inner = |frame: &Frame| Frame { pixels: middle(frame), ..frame.clone() };
        // Each blend rounds to half an ulp of 1.
        let bound: fn(&Level) -> f64 = |_| 192.0 * 6e-8;
        rows.push(Row::single("each step in two", name(pass), difference(&inner(&whole), &inner(&halves)), bound));

        let mut scene = soft();
        scene.quality.pass = pass;
        let mut renderer = Renderer::new(bench.gpu, library, &ball);
        let own = renderer.render(&scene)?;
        scene.object.stretch = [2.0; 3];
        scene.effect.opacity_rate *= 0.5;
        let scaled = renderer.render(&scene)?;
        rows.push(Row::single("scene times 2, c over 2", name(pass), difference(&own, &scaled), |_| 1e-5));

        let mut scene = preset("fire").map_err(VariantError::from)?;
        scene.object.input = "torus".into();
        (scene.image.size, scene.quality.samples, scene.quality.pass) = ([64, 64], 64, pass);
        let torus = Subject::load(&scene, library, &|_| ())?;
        let mut renderer = Renderer::new(bench.gpu, library, &torus);
        let whole = renderer.render(&scene)?;
        let mut joined = whole.clone();
        joined.pixels.fill([f32::NAN; 4]);
        for bands in [[0..8, 24..44], [8..24, 44..64]] {
            let drawn = renderer.render_bands(&scene, &bands)?;
            for at in bands.into_iter().map(|band| band.start as usize * 64..band.end as usize * 64) {
                joined.pixels[at.clone()].copy_from_slice(&drawn.pixels[at]);
            }
        }
        rows.push(Row::single("bands of the picture", name(pass), difference(&whole, &joined), |_| 0.0));
        if pass == Pass::March {
            scene.quality.empty_space = EmptySpace::Sample;
            let fixed = renderer.render(&scene)?;
            rows.push(Row::single("skipping", name(pass), difference(&whole, &fixed), |_| 0.0));
        }
        passes.push(own);
    }
    rows.push(Row::single("slices against march", "both", difference(&passes[0], &passes[1]), |_| 1e-5));
    Ok(rows)
}

/// The middle quarter of a picture.
fn middle(frame: &Frame) -> Vec<[f32; 4]> {
    let [width, height] = frame.size.map(|side| side as usize);
    let columns = width * 3 / 8..width * 5 / 8;
    (height * 3 / 8..height * 5 / 8).flat_map(|row| frame.pixels[row * width..][columns.clone()].to_vec()).collect()
}

/// Optical depth 2, cut into ever more slices, in each format of the target.
pub(super) fn layers(bench: &Bench<'_>) -> Result<Vec<Row>, RenderError> {
    let truth = super::closed::slab(3.0, 3.0, 2.0 / 3.0);
    let subject = box_subject(SLAB);
    let mut scene = homogeneous("cube", 3.0, Projection::Parallel);
    (scene.image.size, scene.camera.zoom, scene.quality.pass) = ([8, 8], 4.0, Pass::Slices);
    type Case = (&'static str, TargetFormat, Option<fn(&Level) -> f64>, &'static str);
    let cases: [Case; 3] = [
        ("float32 target", TargetFormat::Float32, Some(|_| 1e-5), ""),
        // (1 - A) alpha must be above half an ulp of A.
        ("float16 target", TargetFormat::Float16, Some(|level| 2e-4 * f64::from(level.samples)), ""),
        ("unorm8 target", TargetFormat::Unorm8, None, "for comparison: the paper's target loses thin matter"),
    ];
    let mut renderer = Renderer::new(bench.gpu, &bench.library, &subject);
    let mut rows = Vec::new();
    for (what, format, bound, note) in cases {
        scene.quality.target = format;
        let mut levels = Vec::new();
        for slices in [64, 256, 1024] {
            scene.quality.samples = 3 * slices;
            let frame = renderer.render(&scene)?;
            levels.push(Level::of(slices, 0.0, frame.pixels.iter().map(|pixel| (f64::from(pixel[3]) - truth).abs())));
        }
        let row = Row::of(&levels, bound.unwrap_or(|_| f64::INFINITY), None, "slices");
        rows.push(Row { what: what.into(), note, bound: bound.and(row.bound), ..row });
    }
    Ok(rows)
}
