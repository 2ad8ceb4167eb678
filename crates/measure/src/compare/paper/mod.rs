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

use super::timing::{FEWEST_RUNS, Spread, interleave};
use super::{Comparison, Failure, Session, run};
use crate::worker::Painter;
use hypertexture::gpu::Format;
use hypertexture::render::Frame;
use hypertexture::scene::{Integration, Pass, Scene, TargetFormat};
use hypertexture::shader::Library;
use support::random::SplitMix;

/// One row of Table 3: what the paper calls it, our module, and frames per second in the order of [`COLUMNS`].
pub const TABLE_3: [(&str, &str, [f64; 4]); 4] = [
    ("8 noise lookups", "lookups8", [2.45, 1.89, 0.49, 0.43]),
    ("4 noise lookups", "lookups4", [7.14, 5.26, 2.40, 2.30]),
    ("4 channel", "channels", [23.02, 17.02, 3.82, 3.70]),
    ("encoded texture", "encoded", [23.24, 17.00, 4.18, 4.05]),
];

/// Window size, and whether sampling is 8x.
pub const COLUMNS: [([u32; 2], bool); 4] =
    [([300, 300], false), ([300, 300], true), ([1024, 768], false), ([1024, 768], true)];

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

/// Our Table 3.
#[derive(Clone, Debug)]
pub struct Table {
    /// Slices that were drawn.
    pub slices: u32,
    /// Samples per pixel in place of 8x: what the device has.
    pub sampling: u32,
    /// The rows of [`TABLE_3`].
    pub rows: [[Cell; 4]; 4],
    /// The row of the comparison that has the error of each, by its index.
    pub errors: [Option<usize>; 4],
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

/// Replays Table 3 with the strategies of the comparison; `None` if it has none of them. Quick: its first column alone. A
/// cell that cannot be drawn is missing, and told.
pub fn table(
    session: Session<'_>,
    comparison: &Comparison,
    quick: bool,
    failures: &mut Vec<Failure>,
    progress: &dyn Fn(f32),
) -> Option<Table> {
    let scenes = TABLE_3.map(|(_, module, _)| paper_scene(comparison, &session, module));
    let slices = scenes.iter().flatten().map(|(_, scene)| scene.quality.samples).max()?;
    let mut fail = |row: usize, [width, height]: [u32; 2], error: &dyn ToString| {
        let label = format!("Table 3, {}, {width} x {height}", TABLE_3[row].0);
        failures.push(Failure { label, message: error.to_string() });
    };
    let counts = session.gpu.sample_counts(Format::Rgba8Unorm);
    let counts = if session.gpu.info().sample_shading { counts } else { vec![1] };
    let sampling = counts.into_iter().filter(|&count| count <= 8).max().unwrap_or(1);
    let mut rows = [[Cell::Missing; 4]; 4];
    let columns = if quick { 1 } else { COLUMNS.len() };
    for (column, (size, smooth)) in COLUMNS.into_iter().enumerate().take(columns) {
        let mut cells: Vec<(usize, Scene, Painter<'_>, f64)> = Vec::new();
        for (row, (_, scene)) in scenes.iter().enumerate().filter_map(|(row, found)| Some((row, found.as_ref()?))) {
            if (session.stop)() {
                return None;
            }
            let mut scene = scene.clone();
            scene.image.size = size;
            if smooth {
                (scene.quality.msaa, scene.quality.anisotropy) = (sampling, session.gpu.info().max_anisotropy.min(8.0));
            }
            let samples = f64::from(size[0] * size[1] * scene.quality.msaa) / f64::from(300 * 300);
            let expected = match rows[row][0] {
                Cell::Measured(first) => first.median * samples,
                _ => 0.0,
            };
            if expected > LONGEST_MS {
                rows[row][column] = Cell::Scaled(expected);
                continue;
            }
            let mut renderer = session.painter();
            match run(&mut renderer, &scene) {
                Ok(first) => cells.push((row, scene, renderer, first.gpu_ms)),
                Err(error) => fail(row, size, &error),
            }
            progress((column as f32 + 0.125 * (row + 1) as f32) / columns as f32);
        }
        let runs: Vec<usize> =
            cells.iter().map(|(.., ms)| ((CELL_MS / ms.max(1e-3)) as usize).clamp(2, FEWEST_RUNS + 1)).collect();
        let mut times: Vec<Vec<f64>> = vec![Vec::new(); cells.len()];
        let mut failed: Vec<usize> = Vec::new();
        for index in interleave(&runs, &mut SplitMix(column as u64)) {
            if (session.stop)() {
                return None;
            }
            if failed.contains(&index) {
                continue;
            }
            let (row, scene, renderer, _) = &mut cells[index];
            match run(renderer, scene) {
                Ok(run) => times[index].push(run.gpu_ms),
                Err(error) => {
                    failed.push(index);
                    fail(*row, size, &error);
                }
            }
        }
        for (index, ((row, ..), times)) in cells.iter().zip(&times).enumerate() {
            if !failed.contains(&index) {
                rows[*row][column] = Cell::Measured(Spread::of(times));
            }
        }
        progress((column + 1) as f32 / columns as f32);
    }
    let errors = scenes.map(|found| found.map(|(index, _)| index));
    Some(Table { slices, sampling, rows, errors })
}

/// Gives the turbulence so many octaves: where its block holds fewer, the largest block, with one cell of the first octave.
fn hold(scene: &mut Scene, octaves: u32, library: &Library) {
    scene.effect.octaves = octaves;
    if scene.octaves_held(library) < octaves {
        (scene.quality.block_size, scene.quality.turbulence_cells) = (256, 1);
    }
}

/// The pictures of Fig. 8 that the library has modules for, close to the object, if the scene has turbulence at all. One
/// that cannot be drawn is missing, and told.
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
        let drawn = match scene.quality.block_size == comparison.scene.quality.block_size {
            true => module.into(),
            false => {
                format!(
                    "{module}, a block of {} texels, {} cell",
                    scene.quality.block_size, scene.quality.turbulence_cells
                )
            }
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
