//! Scenes that must give the same picture as another one: for any scene, effect and module.

use super::matter::same;
use super::{Row, StressError};
use crate::gpu::Gpu;
use crate::render::{Frame, RenderError, Renderer, Subject};
use crate::scene::{EmptySpace, Neutral, Order, Pass, Scene};
use crate::shader::Library;

/// A change of a scene that must not change its picture.
pub(super) struct Twin {
    what: &'static str,
    /// How far a channel of linear light may be off.
    bound: f64,
    /// The twin; none where the change says nothing about the scene.
    of: fn(&Scene) -> Option<Scene>,
}

/// What is blended from the other end is rounded otherwise.
const BLENDED: f64 = 2e-5;
/// Programs in which a 0 is a constant are rounded otherwise.
const ROUNDED: f64 = 2e-6;

/// The changes.
const TWINS: [Twin; 5] = [
    Twin { what: "drawn again", bound: 0.0, of: |scene| changed(scene, true, |_| ()) },
    Twin {
        what: "a turn of the camera later",
        bound: 0.0,
        of: |scene| {
            let [before, later] = [scene.camera.azimuth, scene.camera.azimuth + 360.0];
            // What f32 rounds away is no whole turn.
            let is_whole = later - 360.0 == before && scene.camera.rotation.is_none();
            changed(scene, is_whole, |scene| scene.camera.azimuth = later)
        },
    },
    Twin {
        what: "every sample taken",
        bound: 0.0,
        of: |scene| {
            let is_other = scene.quality.empty_space != EmptySpace::Sample && scene.quality.pass == Pass::March;
            changed(scene, is_other, |scene| scene.quality.empty_space = EmptySpace::Sample)
        },
    },
    Twin {
        what: "terms of 0 kept",
        bound: ROUNDED,
        of: |scene| changed(scene, true, |scene| scene.quality.neutral = Neutral::Keep),
    },
    Twin {
        what: "slices from the other end",
        bound: BLENDED,
        of: |scene| {
            let plain = scene.quality.early_termination == 0.0 && !scene.is_half_angle();
            changed(scene, plain && scene.quality.pass == Pass::Slices, |scene| {
                scene.quality.order = match scene.quality.order {
                    Order::FrontToBack => Order::BackToFront,
                    Order::BackToFront => Order::FrontToBack,
                };
            })
        },
    },
];

fn changed(scene: &Scene, applies: bool, change: impl FnOnce(&mut Scene)) -> Option<Scene> {
    let mut twin = scene.clone();
    change(&mut twin);
    applies.then_some(twin)
}

/// Holds the twins of a scene against it.
pub(super) fn rows(gpu: &Gpu, library: &Library, scene: &Scene, setting: &str) -> Result<Vec<Row>, StressError> {
    let subject = Subject::load(scene, library, &|_| ())?;
    let mut renderer = Renderer::new(gpu, library, &subject);
    let frame = renderer.render(scene)?;
    let row = |what: &str, bound: f64, other: Result<Frame, RenderError>| match other {
        Ok(other) => Row::worst(what, setting, same(&frame, &other, bound)),
        Err(error) => Row::said(what, setting, "the same picture", error.to_string(), false),
    };
    let mut rows = Vec::new();
    for Twin { what, bound, of } in TWINS {
        if let Some(twin) = of(scene).filter(|twin| twin.check(library).is_ok()) {
            rows.push(row(what, bound, renderer.render(&twin)));
        }
    }
    // Not another scene, but another way to the same picture.
    let [width, height] = scene.image.size;
    let cuts = [0, height / 3, height - height / 4, height];
    let mut pixels = Vec::new();
    for rows in cuts.windows(2).map(|rows| rows[0]..rows[1]).filter(|rows| !rows.is_empty()) {
        let of_rows = (rows.start * width) as usize..(rows.end * width) as usize;
        pixels.extend_from_slice(&renderer.render_bands(scene, &[rows])?.pixels[of_rows]);
    }
    rows.push(row("drawn in bands", 0.0, Ok(Frame { pixels, ..frame.clone() })));
    Ok(rows)
}
