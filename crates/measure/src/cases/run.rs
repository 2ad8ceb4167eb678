//! Cases and their runner.

use super::analytic::AnalyticCase;
use super::lab::{CaseError, Lab, PASSES, Report, Row, Rows};
use crate::compare::report::Environment;
use hypertexture::field::Progress;
use hypertexture::gpu::Gpu;
use hypertexture::shader::Library;
use serde::Serialize;

/// The command that runs a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Suite {
    /// `verify`: analytic pictures and invariances.
    Verify,
    /// `stress`: formulas, floats and devices at the limits of their ranges.
    Stress,
}

/// A case.
#[derive(Clone, Copy)]
pub struct Case {
    /// The command that runs it.
    pub suite: Suite,
    /// Number within its suite.
    pub number: u32,
    /// Name.
    pub name: &'static str,
    /// How it is measured.
    pub measure: Measure,
}

/// Measurement of a case.
#[derive(Clone, Copy)]
pub enum Measure {
    /// Pictures with a closed form of every pixel, in both passes.
    Analytic(&'static [AnalyticCase]),
    /// A function that adds its rows.
    Rows(fn(&Lab<'_>, &mut Rows) -> Result<(), CaseError>),
}

/// Measures cases; a case that cannot be drawn reports a row that fails.
///
/// # Errors
/// The GLSL compiler cannot be started.
pub fn run(gpu: &Gpu, library: Library, cases: &[Case], progress: Progress<'_>) -> Result<Report, CaseError> {
    let lab = Lab::new(gpu, library)?;
    let mut rows = Vec::new();
    for (done, &Case { number, name, measure, .. }) in cases.iter().enumerate() {
        progress(done as f32 / cases.len() as f32);
        let mut found = Rows::default();
        let outcome = match measure {
            Measure::Analytic(cases) => {
                cases.iter().flat_map(|case| PASSES.map(|pass| (case, pass))).try_for_each(|(case, pass)| {
                    found.push(case.row(&lab, pass)?);
                    Ok(())
                })
            }
            Measure::Rows(add) => add(&lab, &mut found),
        };
        if let Err(error) = outcome {
            found.holds(name, "all", "pictures", error.to_string(), false);
        }
        rows.extend(found.into_vec().into_iter().map(|row| Row { case: number, name, ..row }));
    }
    Ok(Report { environment: Environment::of(gpu), rows })
}
