//! Cases and their runner.

use super::analytic::AnalyticCase;
use super::lab::{CaseError, Lab, PASSES, Report, Row, Rows};
use crate::compare::report::Environment;
use hypertexture::field::Progress;
use hypertexture::gpu::{Gpu, GpuError, Options};
use hypertexture::shader::Library;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

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

/// Devices for [`run`]: `first`, and where it is the processor one for each further core, up to 8 in all, since a driver
/// compiles the shaders of one device by one thread.
///
/// # Errors
/// As [`Gpu::new`].
pub fn devices(first: Gpu, options: &Options) -> Result<Vec<Gpu>, GpuError> {
    let cores = if first.info().cpu { std::thread::available_parallelism().map_or(1, usize::from).min(8) } else { 1 };
    std::iter::once(Ok(first)).chain((1..cores).map(|_| Gpu::new(options))).collect()
}

/// Measures cases, beside each other on several devices of one kind; a case that cannot be drawn reports a row that fails.
///
/// # Errors
/// The GLSL compiler cannot be started.
///
/// # Panics
/// `devices` is empty.
pub fn run(devices: &[Gpu], library: &Library, cases: &[Case], progress: Progress<'_>) -> Result<Report, CaseError> {
    let labs = devices.iter().map(|gpu| Lab::new(gpu, library.clone())).collect::<Result<Vec<_>, _>>()?;
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let rows = Mutex::new(vec![Vec::new(); cases.len()]);
    let work = |lab: Lab<'_>| {
        while let Some((place, case)) = Some(next.fetch_add(1, Relaxed)).and_then(|at| Some((at, cases.get(at)?))) {
            let found = case.rows(&lab);
            rows.lock().unwrap_or_else(PoisonError::into_inner)[place] = found;
            progress((done.fetch_add(1, Relaxed) + 1) as f32 / cases.len() as f32);
        }
    };
    let work = &work;
    std::thread::scope(|scope| labs.into_iter().for_each(|lab| drop(scope.spawn(move || work(lab)))));
    let rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner).concat();
    Ok(Report { environment: Environment::of(&devices[0]), rows })
}

impl Case {
    /// Rows of the case.
    fn rows(&self, lab: &Lab<'_>) -> Vec<Row> {
        let mut found = Rows::default();
        let outcome = match self.measure {
            Measure::Analytic(cases) => {
                cases.iter().flat_map(|case| PASSES.map(|pass| (case, pass))).try_for_each(|(case, pass)| {
                    found.push(case.row(lab, pass)?);
                    Ok(())
                })
            }
            Measure::Rows(add) => add(lab, &mut found),
        };
        if let Err(error) = outcome {
            found.holds(self.name, "all", "pictures", error.to_string(), false);
        }
        found.into_vec().into_iter().map(|row| Row { case: self.number, name: self.name, ..row }).collect()
    }
}
