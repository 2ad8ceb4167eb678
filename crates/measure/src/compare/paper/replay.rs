//! The paper's Tables 1, 2 and 3, its remark about discarded fragments, its block of noise and its Eq. 7, replayed on
//! one object.
//!
//! Role: the six effects into scenes as the paper drew them ([`paper_quality`]), one for each row and window;
//! [`super::measure`] times them.
//! Source: MJ 3.5, 5.2 and 7.

use super::numbers::{CARDS, EFFECTS};
use super::{Cell, TABLE_3, Way};
use hypertexture::gpu::{Format, Gpu};
use hypertexture::render::Frame;
use hypertexture::scene::{Integration, Pass, Proxy, Quality, Scene, TargetFormat};
use serde::Serialize;

/// Slices, unless asked otherwise: about one for each voxel of the volumes of 2005.
pub const SLICES: u32 = 128;
/// Sides of the blocks of noise that are tried, texels.
const BLOCKS: [u32; 5] = [16, 32, 64, 128, 256];
/// A block from this side on takes longer to bake than all else of a quick look.
const SLOW_BLOCK: u32 = 256;

/// A window of the paper. Its sampling, 0, 4 or 8 times, is antialiasing and anisotropic filtering together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Window {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples of a pixel and anisotropy; 0 turns both off.
    pub sampling: u32,
}

/// The windows, from the quickest on. The paper does not print 4x, as it is about 8x.
pub(crate) const WINDOWS: [Window; 6] = [
    Window { size: [300, 300], sampling: 0 },
    Window { size: [300, 300], sampling: 4 },
    Window { size: [300, 300], sampling: 8 },
    Window { size: [1024, 768], sampling: 0 },
    Window { size: [1024, 768], sampling: 4 },
    Window { size: [1024, 768], sampling: 8 },
];

/// The windows that the paper prints, by their places.
const PRINTED: [usize; 4] = [0, 2, 3, 5];

/// Settings of a replay.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scenes of [`EFFECTS`], of one object, by [`paper_quality`].
    pub effects: Vec<Scene>,
    /// The windows are this part of the paper's in width and height, 1 but for a quick look, which leaves out the largest
    /// block of noise.
    pub scale: f64,
    /// The first window alone.
    pub quick: bool,
    /// Timed runs of a cell, at most.
    pub repeat: usize,
    /// Pixels of the pictures that are held against their reference.
    pub error_size: [u32; 2],
}

/// Samples and anisotropy of a window's 4x and 8x on this device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sampling {
    counts: Vec<u32>,
    anisotropy: f32,
}

impl Sampling {
    /// Of a device with these numbers of samples and this largest anisotropy.
    pub fn new(counts: Vec<u32>, anisotropy: f32) -> Sampling {
        Sampling { counts, anisotropy }
    }

    /// Of a device, for pictures of this format.
    pub fn of_device(gpu: &Gpu, target: TargetFormat) -> Sampling {
        let format = match target {
            TargetFormat::Unorm8 => Format::Rgba8Unorm,
            TargetFormat::Float16 => Format::Rgba16Float,
            TargetFormat::Float32 => Format::Rgba32Float,
        };
        let info = gpu.info();
        let counts = if info.sample_shading { gpu.sample_counts(format) } else { vec![1] };
        Sampling::new(counts, info.max_anisotropy)
    }

    /// Samples of a pixel and anisotropy in place of so many times: the most that the device has up to there.
    pub fn of(&self, times: u32) -> (u32, f32) {
        let most = self.counts.iter().copied().filter(|&count| count <= times).max().unwrap_or(1);
        (most, self.anisotropy.min(times as f32).max(1.0))
    }
}

/// A column of a table of ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Column {
    /// The window.
    pub window: Window,
    /// Treatment of fragments without matter.
    pub discards: bool,
}

/// A scene that is timed.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The row and the window in words.
    pub label: String,
    /// The scene.
    pub scene: Scene,
    /// Its time.
    pub cell: Cell,
    /// Why it failed.
    pub message: Option<String>,
    /// BLAKE3 of its pixels.
    pub picture: Option<String>,
}

/// How far the picture of a row is from its reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Root mean square error of premultiplied linear RGB.
    pub rmse: f64,
    /// Mean of FLIP.
    pub flip: f64,
    /// Root mean square error against a reference of its own octaves alone, where that is known.
    pub own_rmse: Option<f64>,
    /// How many times faster the fastest candidate of a comparison with at most this error is.
    pub times_faster: Option<f64>,
}

/// A row of a table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name in the paper.
    pub name: String,
    /// The shot of each column; `None` where it is not asked for.
    pub shots: Vec<Option<usize>>,
    /// Frames per second of the cards of the table in each column, where the paper prints them.
    pub paper: Vec<Vec<Option<f64>>>,
    /// The error that the paper lacks, of the first column at [`Plan::error_size`]; or the reason why it is missing.
    pub errors: Option<Result<Errors, String>>,
    /// Its scene, but for window and sampling.
    pub scene: Scene,
}

/// A table of the paper beside ours.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Its heading.
    pub title: &'static str,
    /// The cards that the paper has figures of.
    pub cards: &'static [&'static str],
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows.
    pub rows: Vec<Row>,
}

/// A picture of the sweep of Eq. 7.
#[derive(Clone, Debug)]
pub struct Bump {
    /// k.
    pub k: f32,
    /// Mean angle between the normal that is shaded with and that of the volume, degrees.
    pub angle: f64,
    /// The picture.
    pub frame: Frame,
}

/// Result of a replay.
#[derive(Clone, Debug)]
pub struct Replay {
    /// Requested settings.
    pub plan: Plan,
    /// Substitutes of 4x and 8x.
    pub sampling: Sampling,
    /// Tables 1 and 2, Table 3, discarded fragments, blocks of noise: see `EFFECTS_SHEET` and on.
    pub sheets: Vec<Sheet>,
    /// All that was timed, each once.
    pub shots: Vec<Shot>,
    /// The sweep of Eq. 7, by rising k.
    pub bumps: Vec<Bump>,
    /// The reason for a missing sweep.
    pub bump_failure: Option<String>,
    /// Whether it was stopped before its end.
    pub partial: bool,
}

/// Places of the tables in [`Replay::sheets`].
pub(crate) const EFFECTS_SHEET: usize = 0;
/// Table 3.
pub(crate) const TURBULENCE_SHEET: usize = 1;
/// Fragments without matter, discarded or blended with alpha 0.
pub(crate) const DISCARD_SHEET: usize = 2;
/// Blocks of noise.
pub(crate) const BLOCK_SHEET: usize = 3;

/// How the paper draws: slices that fit every rotation, samples of points, a frame buffer of 8 bits.
pub fn paper_quality(quality: &Quality) -> Quality {
    Quality {
        pass: Pass::Slices,
        integration: Integration::Point,
        samples: SLICES,
        target: TargetFormat::Unorm8,
        proxy: Proxy::Quads,
        msaa: 1,
        anisotropy: 1.0,
        ..quality.clone()
    }
}

impl Plan {
    fn drawn(&self, scene: &Scene, column: Column, sampling: &Sampling) -> Scene {
        let mut scene = scene.clone();
        scene.image.size = self.pixels(column.window);
        scene.quality.discard_empty_fragments = column.discards;
        (scene.quality.msaa, scene.quality.anisotropy) = sampling.of(column.window.sampling);
        scene
    }

    /// Width and height in which a window of the paper is drawn, pixels.
    pub fn pixels(&self, window: Window) -> [u32; 2] {
        window.size.map(|side| ((f64::from(side) * self.scale).round() as u32).max(1))
    }
}

impl Replay {
    fn new(plan: Plan, sampling: Sampling) -> Replay {
        let (sheets, shots, bumps) = (Vec::new(), Vec::new(), Vec::new());
        Replay { plan, sampling, sheets, shots, bumps, bump_failure: None, partial: false }
    }

    /// Table 3 alone, with these of its rows and their scenes.
    pub(crate) fn of_table_3(
        plan: Plan,
        sampling: Sampling,
        rows: impl Iterator<Item = (&'static Way, Scene)>,
    ) -> Replay {
        let mut replay = Replay::new(plan, sampling);
        let rows = rows.map(|(way, scene)| (way.0.into(), scene, vec![way.2.map(Some).to_vec()])).collect();
        replay.add(
            "Table 3",
            &CARDS[..1],
            PRINTED.map(|index| Column { window: WINDOWS[index], discards: true }).to_vec(),
            rows,
        );
        replay
    }

    /// All tables.
    pub fn planned(plan: Plan, sampling: Sampling) -> Replay {
        let mut replay = Replay::new(plan, sampling);
        let column = |window, discards| Column { window, discards };
        let printed = PRINTED.map(|index| column(WINDOWS[index], true)).to_vec();
        let all = WINDOWS.map(|window| column(window, true)).to_vec();
        let both = [true, false].map(|discards| column(WINDOWS[0], discards)).to_vec();
        let effects = || EFFECTS.iter().zip(replay.plan.effects.clone());
        let fire = replay.plan.effects[EFFECTS.len() - 1].clone();
        let some = |numbers: [f64; 4]| numbers.map(Some).to_vec();
        let table_1_and_2 = effects().map(|(row, scene)| (row.1.into(), scene, row.2.map(some).to_vec())).collect();
        let discarded = effects().map(|(row, scene)| (row.1.into(), scene, Vec::new())).collect();
        let turbulence = TABLE_3.map(|(name, module, [a, b, c, d])| {
            let mut scene = fire.clone();
            scene.effect.turbulence = module.into();
            (name.into(), scene, vec![vec![Some(a), None, Some(b), Some(c), None, Some(d)]])
        });
        let baked = BLOCKS.into_iter().filter(|&side| side < SLOW_BLOCK || replay.plan.scale >= 1.0);
        let blocks = baked.map(|side| {
            let mut scene = fire.clone();
            scene.quality.block_size = side;
            (format!("{side}³"), scene, Vec::new())
        });
        let blocks = blocks.collect();
        replay.add("Tables 1 and 2: effects", &CARDS, printed, table_1_and_2);
        replay.add("Table 3: turbulence, on Fire", &CARDS[..1], all, turbulence.to_vec());
        replay.add("Sect. 7: fragments without matter", &[], both.clone(), discarded);
        replay.add("Sect. 7: blocks of turbulence, on Fire", &[], both[..1].to_vec(), blocks);
        replay
    }

    fn add(&mut self, title: &'static str, cards: &'static [&'static str], columns: Vec<Column>, rows: Vec<Planned>) {
        let mut sheet = Sheet { title, cards, columns, rows: Vec::new() };
        for (name, scene, paper) in rows {
            let shots = sheet.columns.iter().map(|&column| self.shot(&name, &scene, column)).collect();
            sheet.rows.push(Row { name, shots, paper, errors: None, scene });
        }
        self.sheets.push(sheet);
    }

    /// The index of a scene among all that is timed; `None` for what a quick replay leaves out.
    fn shot(&mut self, name: &str, scene: &Scene, column: Column) -> Option<usize> {
        if self.plan.quick && column.window != WINDOWS[0] {
            return None;
        }
        let scene = self.plan.drawn(scene, column, &self.sampling);
        Some(self.shots.iter().position(|shot| shot.scene == scene).unwrap_or_else(|| {
            let ([width, height], sampling) = (scene.image.size, column.window.sampling);
            let label = format!("{name} at {width} x {height}, {sampling}x");
            self.shots.push(Shot { label, scene, cell: Cell::Missing, message: None, picture: None });
            self.shots.len() - 1
        }))
    }

    /// The time of a row in a column.
    pub fn cell(&self, row: &Row, column: usize) -> Cell {
        row.shots[column].map_or(Cell::Missing, |shot| self.shots[shot].cell)
    }

    /// Every failure, in words.
    pub fn failures(&self) -> Vec<String> {
        let shots = self.shots.iter().filter_map(|shot| shot.message.clone());
        let rows = self.sheets.iter().flat_map(|sheet| &sheet.rows);
        let errors = rows.filter_map(|row| match &row.errors {
            Some(Err(reason)) => Some(format!("{}: {reason}", row.name)),
            _ => None,
        });
        let mut all: Vec<String> = shots.chain(errors).chain(self.bump_failure.clone()).collect();
        all.sort();
        all.dedup();
        all
    }

    /// Milliseconds that a shot may take, from the same scene in another window: in proportion to pixels and samples.
    pub fn expected(&self, index: usize) -> Option<f64> {
        let asked = &self.shots[index].scene;
        let smooth = |scene: &Scene| (scene.quality.msaa, scene.quality.anisotropy.to_bits());
        let base = |scene: &Scene| {
            let mut base = scene.clone();
            (base.image.size, base.quality.msaa, base.quality.anisotropy) = ([1; 2], 1, 1.0);
            base
        };
        let samples =
            |scene: &Scene| scene.image.size.map(f64::from).iter().product::<f64>() * f64::from(scene.quality.msaa);
        let same = base(asked);
        let known = self.shots.iter().filter_map(|shot| match shot.cell {
            Cell::Measured(spread) if base(&shot.scene) == same => Some((&shot.scene, spread.median)),
            _ => None,
        });
        let nearest = known.min_by_key(|(scene, _)| smooth(scene) != smooth(asked));
        nearest.map(|(scene, ms)| ms * samples(asked) / samples(scene))
    }
}

/// Name, scene, and what the paper's cards do.
type Planned = (String, Scene, Vec<Vec<Option<f64>>>);
