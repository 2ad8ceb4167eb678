//! A stability laboratory: the method at the ends of what it can be asked.
//!
//! Role: [`CASES`] lists what is known to go wrong in the papers' formulas, in f32 and on devices; each is drawn on the
//! device at hand at its extreme and just inside, and held against a closed form in f64, against a relation that must hold,
//! or against a refusal by name. [`sweep`] does the same to a scene of one's own, and holds it against its twins.
//! Invariant: an answer shares nothing with the GLSL; what cannot be drawn is a row that fails, not the end of the others.

mod camera;
mod data;
mod fields;
mod function;
mod glass;
mod matter;
mod noise;
mod opacity;
mod optimizer;
mod relations;
mod report;
mod shaping;
mod sweep;
mod twins;

pub use report::{chart_page, table};
pub use sweep::{Corner, SIDE, Swept, sweep};

use super::verify::Bench;
use crate::compare::report::Environment;
use hypertexture::field::Progress;
use hypertexture::gpu::{Gpu, GpuError};
use hypertexture::render::RenderError;
use hypertexture::scene::{Scene, SceneError};
use hypertexture::shader::{Library, LinkError, Linker};
use serde::Serialize;

/// Why a row could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum StressError {
    /// There is no picture.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// There is no such scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A function cannot be linked.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The device refuses.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// What cases are measured with.
pub struct Lab<'a> {
    /// The device, and the modules of the closed forms.
    bench: Bench<'a>,
    linker: Linker,
}

/// Something that goes wrong where nobody minds it.
#[derive(Clone, Copy)]
pub struct Case {
    /// Its number.
    pub number: u32,
    /// What it is.
    pub name: &'static str,
    /// How it is measured.
    rows: fn(&Lab<'_>) -> Result<Vec<Row>, StressError>,
}

/// The cases: 1 to 45 are of formulas, floats and devices, 46 is what a picture's lines tell, 47 what is refused besides.
pub const CASES: &[Case] = &[
    Case { number: 1, name: "bias near 1", rows: shaping::bias_near_1 },
    Case { number: 2, name: "bias near 0", rows: shaping::bias_near_0 },
    Case { number: 3, name: "gain near its ends", rows: shaping::gain_at_ends },
    Case { number: 4, name: "shaping without a largest slope", rows: relations::steep },
    Case { number: 5, name: "shaping beyond [0, 1]", rows: shaping::beyond },
    Case { number: 6, name: "softness to 0", rows: matter::soft_to_hard },
    Case { number: 7, name: "soft region wider than the object", rows: matter::wide },
    Case { number: 8, name: "iso-values in the wrong order", rows: relations::refused::<8> },
    Case { number: 9, name: "full density over no path", rows: opacity::ends },
    Case { number: 10, name: "opacity of a point", rows: opacity::points },
    Case { number: 11, name: "opacity rate", rows: matter::rates },
    Case { number: 12, name: "opacity of a segment", rows: opacity::segments },
    Case { number: 13, name: "unions", rows: data::unions },
    Case { number: 14, name: "many slices", rows: matter::slices },
    Case { number: 15, name: "early termination", rows: matter::termination },
    Case { number: 16, name: "wide views", rows: camera::wide },
    Case { number: 17, name: "numbers of samples", rows: relations::refused::<17> },
    Case { number: 18, name: "eye at and in the matter", rows: camera::eye },
    Case { number: 19, name: "pictures without pixels", rows: relations::refused::<19> },
    Case { number: 20, name: "bits of a distance", rows: fields::bits },
    Case { number: 21, name: "weights of filters", rows: fields::filters },
    Case { number: 22, name: "normals on the medial axis", rows: fields::medial },
    Case { number: 23, name: "normals along an axis", rows: fields::normals },
    Case { number: 24, name: "noise far from the origin", rows: noise::far },
    Case { number: 25, name: "noise around 0", rows: noise::negative },
    Case { number: 26, name: "noise of what is no place", rows: noise::endless },
    Case { number: 27, name: "texts that differ by device", rows: data::texts },
    Case { number: 28, name: "noise that repeats", rows: noise::periods },
    Case { number: 29, name: "octaves past Nyquist", rows: relations::nyquist },
    Case { number: 30, name: "bounds of noise", rows: noise::bounds },
    Case { number: 31, name: "matter without end", rows: data::hulls },
    Case { number: 32, name: "rays that bend", rows: glass::order },
    Case { number: 33, name: "index of refraction to 1", rows: glass::to_none },
    Case { number: 34, name: "voxels that are no numbers", rows: data::voxels },
    Case { number: 35, name: "thin and odd grids", rows: fields::thin },
    Case { number: 36, name: "more than a device has", rows: relations::refused::<36> },
    Case { number: 37, name: "size of the object", rows: fields::sizes },
    Case { number: 38, name: "meshes that are not closed", rows: data::meshes },
    Case { number: 39, name: "turns of the trackball", rows: camera::turns },
    Case { number: 40, name: "objects pressed flat", rows: relations::refused::<40> },
    Case { number: 41, name: "what leaves out nothing that is seen", rows: relations::skipping },
    Case { number: 42, name: "programs with and without optimizer", rows: optimizer::rows },
    Case { number: 43, name: "formats of the target", rows: matter::formats },
    Case { number: 44, name: "codes of colors", rows: data::codes },
    Case { number: 45, name: "long times", rows: relations::times },
    Case { number: 46, name: "what is told", rows: relations::told },
    Case { number: 47, name: "values beyond their range", rows: relations::refused::<47> },
];

/// One measurement.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Number of the case.
    pub case: u32,
    /// What of it.
    pub what: String,
    /// The value at which it was measured.
    pub setting: String,
    /// That as a number, where rows that differ in it make a curve.
    pub stiffness: Option<f64>,
    /// What must come out, at the place that is the worst.
    pub expected: String,
    /// What came out there.
    pub found: String,
    /// How far apart they are.
    pub error: f64,
    /// How far they may be.
    pub bound: f64,
}

/// A value that is known: what must come out, what did, and how far apart they may be.
type Known = (f64, f64, f64);

impl Row {
    /// The one of known values that is worst for what it may be.
    fn worst(what: &str, setting: impl Into<String>, known: impl IntoIterator<Item = Known>) -> Row {
        // What is known of nothing is as wrong as can be.
        let mut worst = (f64::NEG_INFINITY, [f64::NAN, f64::NAN, f64::INFINITY, 0.0]);
        for (expected, found, bound) in known {
            let error = if expected == found { 0.0 } else { (found - expected).abs() };
            let error = if error.is_nan() { f64::INFINITY } else { error };
            let share = if error == 0.0 { 0.0 } else { error / bound };
            // Of values that are all exact, the largest tells most.
            if share > worst.0 || share == worst.0 && share == 0.0 && expected.abs() > worst.1[0].abs() {
                worst = (share, [expected, found, error, bound]);
            }
        }
        let [expected, found, error, bound] = worst.1;
        Row { error, bound, ..Row::said(what, setting, report::number(expected), report::number(found), true) }
    }

    /// Something that holds or does not.
    fn said(
        what: &str,
        setting: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        ok: bool,
    ) -> Row {
        Row {
            case: 0,
            what: what.into(),
            setting: setting.into(),
            stiffness: None,
            expected: expected.into(),
            found: found.into(),
            error: if ok { 0.0 } else { f64::INFINITY },
            bound: 0.0,
        }
    }

    /// A point of a curve.
    fn at(self, stiffness: f64) -> Row {
        Row { stiffness: Some(stiffness), ..self }
    }

    /// Whether it is as it must be.
    pub fn ok(&self) -> bool {
        self.error <= self.bound
    }

    /// What must be said of it where it fails.
    pub fn title(&self) -> String {
        format!("case {} ({}, {})", self.case, self.what, self.setting)
    }
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Stress {
    /// Where.
    pub environment: Environment,
    /// The rows, in the order of the cases.
    pub rows: Vec<Row>,
}

impl Stress {
    /// The rows that fail.
    pub fn failed(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| !row.ok())
    }
}

/// Measures cases on a device, of a library that holds the modules of [`super::verify::library`].
///
/// # Errors
/// The GLSL compiler cannot be started.
pub fn run(gpu: &Gpu, library: Library, cases: &[Case], progress: Progress<'_>) -> Result<Stress, StressError> {
    let lab = Lab { bench: Bench { gpu, library }, linker: Linker::new()? };
    let mut rows = Vec::new();
    for (done, case) in cases.iter().enumerate() {
        progress(done as f32 / cases.len() as f32);
        let found = (case.rows)(&lab)
            .unwrap_or_else(|error| vec![Row::said(case.name, "all", "pictures", error.to_string(), false)]);
        rows.extend(found.into_iter().map(|row| Row { case: case.number, ..row }));
    }
    Ok(Stress { environment: Environment::of(gpu), rows })
}

/// The scene with a change, where that is what it is about.
fn with(mut scene: Scene, change: impl FnOnce(&mut Scene)) -> Scene {
    change(&mut scene);
    scene
}

/// A power of two in words.
fn power(exponent: i32) -> String {
    format!("2^{exponent}")
}
