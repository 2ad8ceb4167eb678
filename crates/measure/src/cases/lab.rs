//! The device and modules of a run, and the rows that cases report.

use crate::compare::report::Environment;
use hypertexture::gpu::{Gpu, GpuError};
use hypertexture::render::variant::Checkable;
use hypertexture::render::{Frame, RenderError, Renderer, Subject};
use hypertexture::scene::{Pass, SceneError};
use hypertexture::shader::{Library, LinkError, Linker};
use serde::Serialize;

/// Both passes, with their names in rows.
pub const PASSES: [(Pass, &str); 2] = [(Pass::Slices, "slices"), (Pass::March, "rays")];

/// Failure of a case before its error is known.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// A picture cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A function cannot be linked.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A function cannot be drawn.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// The device, the modules and the linker of a run.
pub struct Lab<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The modules, those of [`super::library`] among them.
    pub library: Library,
    /// The linker of single functions.
    pub linker: Linker,
}

impl<'a> Lab<'a> {
    /// A lab on a device.
    ///
    /// # Errors
    /// The GLSL compiler cannot be started.
    pub fn new(gpu: &'a Gpu, library: Library) -> Result<Lab<'a>, LinkError> {
        Ok(Lab { gpu, library, linker: Linker::new()? })
    }

    pub(crate) fn subject(&self, scene: &impl Checkable) -> Result<Subject, RenderError> {
        Subject::load(scene, &self.library, &|_| ())
    }

    pub(crate) fn renderer(&self, subject: &Subject) -> Renderer {
        Renderer::new(self.gpu, &self.library, subject)
    }

    pub(crate) fn render(&self, scene: &impl Checkable, subject: &Subject) -> Result<Frame, RenderError> {
        self.renderer(subject).render(scene)
    }
}

/// One measurement.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Number of the case.
    pub case: u32,
    /// Name of the case.
    pub name: &'static str,
    /// Measured quantity.
    pub what: String,
    /// Setting at which it was measured.
    pub setting: String,
    /// The setting as a number, if rows that differ in it form a curve.
    pub stiffness: Option<f64>,
    /// Expected value where the error is largest relative to its bound.
    pub expected: String,
    /// Value that was found there.
    pub found: String,
    /// Largest error.
    pub error: f64,
    /// Largest error allowed.
    pub bound: f64,
    /// Mean error over a picture.
    pub mean: Option<f64>,
    /// Observed order of convergence.
    pub order: Option<f64>,
    /// Whether error and order are within their bounds.
    pub ok: bool,
}

/// Expected value, value found and bound of their difference.
pub type Known = (f64, f64, f64);

impl Row {
    pub(super) fn new(what: impl Into<String>, setting: impl Into<String>, [error, bound]: [f64; 2]) -> Row {
        Row {
            case: 0,
            name: "",
            what: what.into(),
            setting: setting.into(),
            stiffness: None,
            expected: String::new(),
            found: String::new(),
            error,
            bound,
            mean: None,
            order: None,
            ok: error <= bound,
        }
    }

    /// Marks the row as a point of a curve.
    pub(super) fn at(&mut self, stiffness: impl Into<f64>) {
        self.stiffness = Some(stiffness.into());
    }

    /// Case, quantity and setting.
    pub fn title(&self) -> String {
        format!("case {} ({}, {})", self.case, self.what, self.setting)
    }
}

/// The rows of a case.
#[derive(Default)]
pub struct Rows(Vec<Row>);

impl Rows {
    pub(crate) fn into_vec(self) -> Vec<Row> {
        self.0
    }

    pub(crate) fn push(&mut self, row: Row) -> &mut Row {
        self.0.push(row);
        let last = self.0.len() - 1;
        &mut self.0[last]
    }

    /// Adds the known value whose error is largest relative to its bound.
    pub(crate) fn worst(
        &mut self,
        what: impl Into<String>,
        setting: impl Into<String>,
        known: impl IntoIterator<Item = Known>,
    ) -> &mut Row {
        // No known value at all is an infinite error.
        let mut worst = (f64::NEG_INFINITY, [f64::NAN, f64::NAN, f64::INFINITY, 0.0]);
        for (expected, found, bound) in known {
            let error = if expected == found { 0.0 } else { (found - expected).abs() };
            let error = if error.is_nan() { f64::INFINITY } else { error };
            let share = if error == 0.0 { 0.0 } else { error / bound };
            // Of exact values, the largest is shown.
            if share > worst.0 || share == worst.0 && share == 0.0 && expected.abs() > worst.1[0].abs() {
                worst = (share, [expected, found, error, bound]);
            }
        }
        let [expected, found, error, bound] = worst.1;
        let row = Row::new(what, setting, [error, bound]);
        self.push(Row { expected: number(expected), found: number(found), ..row })
    }

    /// Adds a condition.
    pub(crate) fn holds(
        &mut self,
        what: impl Into<String>,
        setting: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        ok: bool,
    ) {
        let row = Row::new(what, setting, [if ok { 0.0 } else { f64::INFINITY }, 0.0]);
        self.push(Row { expected: expected.into(), found: found.into(), ..row });
    }
}

/// Pairs the values of two pictures that must differ by at most `bound`.
pub fn same(one: &Frame, other: &Frame, bound: f64) -> impl Iterator<Item = Known> {
    let channels = one.pixels.as_flattened().iter().zip(other.pixels.as_flattened());
    channels.map(move |(one, other)| (f64::from(*one), f64::from(*other), bound))
}

/// Result of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Device and machine.
    pub environment: Environment,
    /// Rows, in the order of the cases.
    pub rows: Vec<Row>,
}

impl Report {
    /// The rows that fail.
    pub fn failed(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| !row.ok)
    }
}

/// A number with six decimals, or in scientific notation if it is small or large.
pub(super) fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        1e-3..1e4 => {
            let text = format!("{value:.6}");
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        }
        _ => format!("{value:.3e}"),
    }
}
