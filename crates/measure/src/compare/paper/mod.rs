//! The paper's Table 3 and Fig. 8, replayed: the ways to get turbulence, by frames per second and by error.
//!
//! Source: Miller and Jones 2005, Table 3 (ATI Radeon 9700 Pro) and Fig. 8. The paper says neither how many slices it
//! drew nor into what format; here it is those of the comparison's 8-bit slices. Its 8x is antialiasing and anisotropic
//! filtering together; here every sample of a pixel is shaded.

pub mod conclusions;
#[cfg(test)]
pub mod example;
pub mod measure;
pub mod numbers;
pub mod replay;

use super::front::cheapest;
use super::metrics::Metrics;
use super::timing::{FEWEST_RUNS, Spread};
use super::{Comparison, Failure, Row, Session};
use hypertexture::render::Frame;
use hypertexture::scene::{Integration, Pass, Scene, TargetFormat};
use hypertexture::shader::Library;
use replay::{Errors, Plan, Replay, Sampling};
use std::sync::Arc;

/// One row of Table 3: the paper's name, our module, and frames per second at 300 x 300 and at 1024 x 768, each without
/// smoothing and with 8x.
pub type Way = (&'static str, &'static str, [f64; 4]);

/// The rows of Table 3.
pub(crate) static TABLE_3: [Way; 4] = [
    ("8 noise lookups", "lookups8", [2.45, 1.89, 0.49, 0.43]),
    ("4 noise lookups", "lookups4", [7.14, 5.26, 2.40, 2.30]),
    ("4 channel", "channels", [23.02, 17.02, 3.82, 3.70]),
    ("encoded texture", "encoded", [23.24, 17.00, 4.18, 4.05]),
];

/// The four pictures of Fig. 8: module and caption.
const FIGURE_8: [(&str, u32, &str); 4] = [
    ("lookups4", 4, "4 octaves, 4 lookups"),
    ("channels", 4, "4 octaves, 1 lookup"),
    ("lookups8", 8, "8 octaves, 8 lookups"),
    ("encoded", 8, "8 octaves, 1 lookup"),
];

/// A picture that would take longer is not drawn: its time is in proportion to that of the first column.
const LONGEST_MS: f64 = 8000.0;
/// Time for the repetitions of a cell, milliseconds, of which there are at least two.
const CELL_MS: f64 = 3000.0;
/// Pixels along the sides of a picture of Fig. 8.
const CROP: u32 = 256;
/// How much closer than the scene's own its camera is.
const CLOSER: f32 = 2.6;

/// A cell of our table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// Milliseconds on the device, measured.
    Measured(Spread),
    /// Milliseconds in proportion to pixels and samples of the first column: it was not drawn.
    Scaled(f64),
    /// It could not be drawn.
    Failed,
    /// Unknown: not requested, or without a module.
    Missing,
}

impl Cell {
    /// Frames per second.
    pub fn rate(&self) -> Option<f64> {
        match self {
            Cell::Measured(spread) => Some(1e3 / spread.median),
            Cell::Scaled(ms) => Some(1e3 / ms),
            Cell::Failed | Cell::Missing => None,
        }
    }
}

/// One picture of Fig. 8.
#[derive(Clone, Debug)]
pub struct Crop {
    /// The paper's caption.
    pub caption: &'static str,
    /// The module, and its block if it differs from the scene's.
    pub drawn: String,
    /// The picture.
    pub frame: Frame,
}

/// The scene of a row: its strategy, on slices of 8 bits.
fn paper_scene(comparison: &Comparison, session: &Session<'_>, module: &str) -> Option<(usize, Scene)> {
    if !session.library.modules("turbulence").contains(&module) {
        return None;
    }
    let is_paper = |index: &usize| {
        let (candidate, own) = (&comparison.rows[*index].candidate, &comparison.scene);
        let curve = candidate.curve();
        candidate.scene.effect.turbulence == module
            && candidate.strategy.starts_with(module)
            && (candidate.strategy == module || candidate.scene.effect.noise == own.effect.noise)
            && (curve.pass, curve.integration, curve.target)
                == (Pass::Slices, Integration::Point, Some(TargetFormat::Unorm8))
            && curve.block.is_none_or(|block| block == own.quality.block_size)
            && candidate.samples() <= own.quality.samples
    };
    let rows = 0..comparison.rows.len();
    let index = rows.filter(is_paper).max_by_key(|&index| comparison.rows[index].candidate.samples())?;
    Some((index, comparison.rows[index].candidate.scene.clone()))
}

/// Replays Table 3 with the strategies of the comparison, at the errors of its rows; `None` if it has none of them or is
/// stopped. Quick: its first column alone. A cell that cannot be drawn is recorded in `failures`.
pub fn table(
    session: Session<'_>,
    comparison: &Comparison,
    quick: bool,
    failures: &mut Vec<Failure>,
    progress: &dyn Fn(f32),
) -> Option<Replay> {
    let found = |way: &'static Way| Some((way, paper_scene(comparison, &session, way.1)?));
    let found: Vec<(&Way, (usize, Scene))> = TABLE_3.iter().filter_map(found).collect();
    let (size, effects) = (comparison.scene.image.size, vec![found.first()?.1.1.clone()]);
    let plan = Plan { effects, scale: 1.0, quick, repeat: FEWEST_RUNS + 1, error_size: size };
    let sampling = Sampling::of_device(session.gpu, TargetFormat::Unorm8);
    let mut replay = Replay::of_table_3(plan, sampling, found.iter().map(|(way, (_, scene))| (*way, scene.clone())));
    measure::time_windows(session, &mut replay, progress);
    for (row, (_, (index, _))) in replay.sheets[0].rows.iter_mut().zip(&found) {
        row.errors = Some(Ok(errors(&comparison.rows, *index)));
    }
    let failed = replay.failures().into_iter();
    failures.extend(failed.map(|message| Failure { label: "Table 3".into(), message }));
    (!(session.stop)()).then_some(replay)
}

/// The errors of a row, and how many times faster a row of the same truth has no larger one.
pub(super) fn errors(rows: &[Row], index: usize) -> Errors {
    let (row, (time, error)) = (&rows[index], rows[index].point());
    let like = rows.iter().filter(|other| Arc::ptr_eq(&other.truth, &row.truth));
    let points: Vec<(f64, f64)> = like.map(Row::point).collect();
    let best = cheapest(&points, error).map_or(time, |best| points[best].0);
    let Metrics { own_rmse, flip, .. } = row.metrics;
    Errors { rmse: error, flip, own_rmse, times_faster: Some(time / best) }
}

/// Gives the turbulence so many octaves: where its block holds fewer, the largest block, with one cell of the first octave.
fn hold(scene: &mut Scene, octaves: u32, library: &Library) {
    scene.effect.octaves = octaves;
    if scene.octaves_held(library) < octaves {
        (scene.quality.block_size, scene.quality.turbulence_cells) = (256, 1);
    }
}

/// The pictures of Fig. 8 that the library has modules for, close to the object, if the scene has turbulence at all. One
/// that cannot be drawn is recorded in `failures`.
pub fn figure(session: Session<'_>, comparison: &Comparison, failures: &mut Vec<Failure>) -> Vec<Crop> {
    let mut crops = Vec::new();
    for (module, octaves, caption) in FIGURE_8 {
        let Some((_, mut scene)) = paper_scene(comparison, &session, module) else { continue };
        if (session.stop)() {
            break;
        }
        hold(&mut scene, octaves, session.library);
        scene.image.size = [CROP; 2];
        scene.camera.zoom *= CLOSER;
        scene.quality.target = TargetFormat::Float32; // as it looks, not as 8 bits lose it
        scene.quality.samples = comparison.scene.quality.samples;
        let drawn = if scene.quality.block_size == comparison.scene.quality.block_size {
            module.into()
        } else {
            format!("{module}, a block of {} texels, {} cell", scene.quality.block_size, scene.quality.turbulence_cells)
        };
        match session.painter().render(&scene) {
            Ok(frame) => crops.push(Crop { caption, drawn, frame }),
            Err(error) => failures.push(Failure { label: format!("Fig. 8, {caption}"), message: error.to_string() }),
        }
    }
    crops
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::shader;

    #[test]
    fn m59_each_picture_of_fig_8_has_the_octaves_of_its_caption() {
        let library = shader::shipped();
        for (module, octaves, caption) in FIGURE_8 {
            let mut scene = Scene::default();
            scene.effect.turbulence = module.into();
            hold(&mut scene, octaves, &library);
            assert_eq!(scene.octaves_held(&library), octaves, "{caption}");
            assert!(scene.check(&library).is_ok(), "{caption}");
        }
    }
}
