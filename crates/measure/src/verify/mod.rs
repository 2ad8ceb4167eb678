//! What must be true of every picture, measured on the device at hand.
//!
//! Role: [`TRUTHS`] lists closed forms with the scenes that they are the pictures of, and what must not change a picture;
//! [`run`] renders them in both passes and tells error, observed order, floor and bound; [`check`] holds a picture on
//! disk against its own scene. Invariant: an answer shares nothing with the GLSL, and a row that could not fail is no row.

mod agreement;
mod analytic;
mod closed;
mod lens;
mod picture;
mod pictures;
mod rays;
mod redrawn;
mod unchanged;
mod volumes;

pub use agreement::Agreement;
pub use analytic::{AnalyticCase, Level, levels, order};
pub use closed::{SoftBall, fish_eye, luneburg_miss, slab};
pub use lens::{clear, probed};
pub use picture::{CheckError, CheckOptions, Knows, Truth as PixelTruth, check, draw_pixels};
pub use pictures::{
    COLOR_BY_DEPTH, HOMOGENEOUS, PERLIN_BALLS, SLAB, SLANTED, SOFT_BALLS, TWO_TONE, TWO_TONES, box_subject,
    homogeneous, library, two_tone,
};
pub use rays::{Ray, rays};
pub use volumes::{face, face_subject};

use hypertexture::field::Progress;
use hypertexture::gpu::Gpu;
use hypertexture::render::RenderError;
use hypertexture::scene::Pass;
use hypertexture::shader::Library;
use serde::Serialize;
use std::fmt::Write;

/// Both passes.
pub const PASSES: [Pass; 2] = [Pass::Slices, Pass::March];

/// What truths are measured with.
pub struct Bench<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// [`library`].
    pub library: Library,
}

impl<'a> Bench<'a> {
    /// On this device.
    pub fn new(gpu: &'a Gpu) -> Bench<'a> {
        Bench { gpu, library: library() }
    }
}

/// Something that is known of pictures.
#[derive(Clone, Copy)]
pub struct Truth {
    /// Number and name.
    pub name: &'static str,
    /// How it is measured.
    pub measure: Measure,
}

/// How a truth is measured.
#[derive(Clone, Copy)]
pub enum Measure {
    /// By pictures with a known answer in every pixel, in both passes.
    Analytic(&'static [AnalyticCase]),
    /// In its own way.
    Other(fn(&Bench<'_>) -> Result<Vec<Row>, RenderError>),
}

/// The truths.
pub const TRUTHS: &[Truth] = &[
    Truth { name: "1 homogeneous matter", measure: Measure::Analytic(HOMOGENEOUS) },
    Truth { name: "2 color by depth", measure: Measure::Analytic(COLOR_BY_DEPTH) },
    Truth { name: "3 soft ball", measure: Measure::Analytic(SOFT_BALLS) },
    Truth { name: "4 soft ball, opacity of PH", measure: Measure::Analytic(PERLIN_BALLS) },
    Truth { name: "5 two-tone ball", measure: Measure::Analytic(TWO_TONES) },
    Truth { name: "6 fields of voxels", measure: Measure::Other(volumes::fields) },
    Truth { name: "7 rays that bend", measure: Measure::Other(lens::lenses) },
    Truth { name: "8 noise", measure: Measure::Other(volumes::noise) },
    Truth { name: "9 what changes nothing", measure: Measure::Other(unchanged::rows) },
    Truth { name: "10 wide view", measure: Measure::Analytic(SLANTED) },
    Truth { name: "10 thin layers", measure: Measure::Other(unchanged::layers) },
];

/// A line of the report.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The truth.
    pub truth: &'static str,
    /// What of it.
    pub what: String,
    /// `slices`, `march` or `both`.
    pub pass: &'static str,
    /// Samples in depth, or cells of voxels along a side.
    pub samples: u32,
    /// Mean absolute error.
    pub mean: f64,
    /// Largest absolute error.
    pub max: f64,
    /// Observed order, where there are pictures enough above the rounding of f32.
    pub order: Option<f64>,
    /// Between what it must lie, where the error falls by an order.
    pub expected: Option<[f64; 2]>,
    /// Mean error that more samples no longer halve as they should, where it was reached.
    pub floor: Option<f64>,
    /// The largest error allowed; none where a row is there to compare with.
    pub bound: Option<f64>,
    /// What else is to be said.
    pub note: &'static str,
    /// Whether the error, and the order, are as they must be.
    pub ok: bool,
}

impl Row {
    /// The row of the finest level, or of the first one that misses its bound.
    fn of(levels: &[Level], bound: impl Fn(&Level) -> f64, expected: Option<[f64; 2]>, pass: &'static str) -> Row {
        let missed = levels.iter().find(|level| level.max > bound(level));
        let shown = missed.or(levels.last()).copied().unwrap_or(Level::of(0, 0.0, std::iter::empty()));
        let order = expected.and_then(|_| order(levels));
        let in_order = match (expected, order) {
            (None, _) => true,
            (Some([low, high]), Some(order)) => (low..=high).contains(&order),
            (Some(_), None) => false,
        };
        let lowest = expected.map_or(0.0, |[low, _]| 0.5 * low);
        let stalled = levels.windows(2).find(|pair| pair[0].order(&pair[1]) < lowest);
        let floor = match expected {
            Some(_) => stalled.map(|pair| pair[1].mean),
            None => Some(shown.mean), // nothing but rounding is in it
        };
        Row {
            truth: "",
            what: String::new(),
            pass,
            samples: shown.samples,
            mean: shown.mean,
            max: shown.max,
            order,
            expected,
            floor,
            bound: Some(bound(&shown)),
            note: "",
            ok: missed.is_none() && in_order,
        }
    }

    /// A row of one error that must stay below a bound.
    fn single(what: &str, pass: &'static str, level: Level, bound: fn(&Level) -> f64) -> Row {
        Row { what: what.into(), ..Row::of(&[level], bound, None, pass) }
    }

    /// What must be said of it where it fails: truth, case, pass, the error or the order, and what it may be.
    pub fn failure(&self) -> String {
        let Row { truth, what, pass, samples, max, .. } = self;
        let why = match (self.bound, self.order, self.expected) {
            (Some(bound), ..) if *max > bound => {
                format!("an error of {max:.1e} with {samples} samples, at most {bound:.1e}")
            }
            (_, Some(order), Some([low, high])) => format!("an order of {order:.2}, between {low} and {high}"),
            _ => "no order, for want of errors above rounding".into(),
        };
        format!("{truth} ({what}, {pass}): {why}")
    }
}

fn name(pass: Pass) -> &'static str {
    match pass {
        Pass::Slices => "slices",
        Pass::March => "march",
    }
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Verification {
    /// The rows, in the order of the truths.
    pub rows: Vec<Row>,
}

/// Measures truths on a device.
///
/// # Errors
/// A picture that cannot be made: a device without what it needs.
pub fn run(gpu: &Gpu, truths: &[Truth], progress: Progress<'_>) -> Result<Verification, RenderError> {
    let bench = Bench::new(gpu);
    let mut rows = Vec::new();
    for (done, truth) in truths.iter().enumerate() {
        progress(done as f32 / truths.len() as f32);
        let found = match truth.measure {
            Measure::Analytic(cases) => cases
                .iter()
                .flat_map(|case| PASSES.map(|pass| case.row(&bench, pass)))
                .collect::<Result<Vec<_>, _>>()?,
            Measure::Other(measure) => measure(&bench)?,
        };
        rows.extend(found.into_iter().map(|row| Row { truth: truth.name, ..row }));
    }
    Ok(Verification { rows })
}

impl Verification {
    /// The rows that miss a bound or an order.
    pub fn missed(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| !row.ok)
    }

    /// The report as a table.
    pub fn text(&self) -> String {
        let head = ["truth", "pass", "N", "mean error", "max error", "order", "expected", "floor", "bound", "ok"];
        let number = |value: f64| if value == 0.0 { "0".into() } else { format!("{value:.1e}") };
        let or_none = |value: Option<String>| value.unwrap_or("-".into());
        let cells = |row: &Row| {
            let ok = match (row.ok, row.note) {
                (true, "") => "yes".into(),
                (false, "") => "NO".into(),
                (true, note) => note.into(),
                (false, note) => format!("NO: {note}"),
            };
            [
                format!("{}: {}", row.truth, row.what),
                row.pass.into(),
                if row.samples == 0 { "-".into() } else { row.samples.to_string() },
                number(row.mean),
                number(row.max),
                or_none(row.order.map(|order| format!("{order:.2}"))),
                or_none(row.expected.map(|[low, high]| format!("{low} to {high}"))),
                match (row.floor, row.expected) {
                    (Some(floor), _) => number(floor),
                    (None, Some(_)) => format!("< {}", number(row.mean)),
                    (None, None) => "-".into(),
                },
                or_none(row.bound.map(number)),
                ok,
            ]
        };
        let table: Vec<[String; 10]> =
            std::iter::once(head.map(String::from)).chain(self.rows.iter().map(cells)).collect();
        let widths: Vec<usize> =
            (0..10).map(|column| table.iter().map(|row| row[column].len()).max().unwrap_or_default()).collect();
        let mut text = String::new();
        for row in &table {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                match column {
                    0 | 1 | 9 => write!(line, "{cell:<width$}  "),
                    _ => write!(line, "{cell:>width$}  "),
                }
                .expect("writing to a string");
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}
