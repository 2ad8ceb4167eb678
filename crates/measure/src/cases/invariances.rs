//! Changes of a scene that must not change its picture.

use super::analytic::Level;
use super::lab::{CaseError, Lab, PASSES, Row, Rows, same};
use super::scenes::{SLAB, box_subject, homogeneous};
use hypertexture::render::Frame;
use hypertexture::scene::{EmptySpace, Pass, Projection, Scene, preset};

/// Adds the difference of two pictures.
fn add(rows: &mut Rows, what: &str, how: &str, [a, b]: [&Frame; 2], bound: f64) {
    let off = same(a, b, bound).map(|(a, b, _)| (a - b).abs());
    let level = Level::of(a.measurements.slices, f64::from(a.measurements.step), off);
    rows.push(Row::converging(format!("{what}, {how}"), &[level], |_| bound, None));
}

/// A soft ball in perspective.
fn soft() -> Scene {
    let mut scene = homogeneous("sphere", 3.0, Projection::Perspective);
    scene.effect.softness = "quadratic".into();
    (scene.object.inner_iso, scene.object.outer_iso) = (-0.6, 0.3);
    (scene.quality.samples, scene.quality.early_termination) = (128, 0.0);
    scene
}

pub(super) fn rows(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let slab = box_subject(SLAB);
    let ball = lab.subject(&soft())?;
    let mut passes = Vec::new();
    for (pass, how) in PASSES {
        let mut scene = homogeneous("cube", 3.0, Projection::Perspective);
        (scene.quality.pass, scene.quality.samples) = (pass, 96);
        let mut renderer = lab.renderer(&slab);
        let coarse = middle(renderer.render(&scene)?);
        scene.quality.samples = 192;
        let fine = middle(renderer.render(&scene)?);
        // Each blend rounds to half an ulp of 1.
        add(rows, "each step in two", how, [&coarse, &fine], 192.0 * 6e-8);

        let mut scene = soft();
        scene.quality.pass = pass;
        let mut renderer = lab.renderer(&ball);
        let original = renderer.render(&scene)?;
        scene.object.stretch = [2.0; 3];
        scene.effect.opacity_rate *= 0.5;
        add(rows, "scene times 2, c over 2", how, [&original, &renderer.render(&scene)?], 1e-5);

        let mut scene = preset("fire")?;
        scene.object.input = "torus".into();
        (scene.image.size, scene.quality.samples, scene.quality.pass) = ([64, 64], 64, pass);
        let mut renderer = lab.renderer(&lab.subject(&scene)?);
        let whole = renderer.render(&scene)?;
        let mut joined = whole.clone();
        joined.pixels.fill([f32::NAN; 4]);
        for bands in [[0..8, 24..44], [8..24, 44..64]] {
            let drawn = renderer.render_bands(&scene, &bands)?;
            for at in bands.into_iter().map(|band| band.start as usize * 64..band.end as usize * 64) {
                joined.pixels[at.clone()].copy_from_slice(&drawn.pixels[at]);
            }
        }
        add(rows, "bands of the picture", how, [&whole, &joined], 0.0);
        if pass == Pass::March {
            scene.quality.empty_space = EmptySpace::Sample;
            add(rows, "skipping", how, [&whole, &renderer.render(&scene)?], 0.0);
        }
        passes.push(original);
    }
    add(rows, "slices against rays", "both", [&passes[0], &passes[1]], 1e-5);
    Ok(())
}

/// The middle quarter of a picture, whose rays pass both faces of the slab.
fn middle(frame: Frame) -> Frame {
    let [width, height] = frame.size.map(|side| side as usize);
    let row = |row: usize| &frame.pixels[row * width..][width * 3 / 8..width * 5 / 8];
    let pixels = (height * 3 / 8..height * 5 / 8).flat_map(|y| row(y).to_vec()).collect();
    Frame { pixels, ..frame.clone() }
}
