//! Times of rows, and the run that is saved.

use super::suite::{Row, Work};
use crate::compare::report::{Environment, load};
use crate::compare::timing::{Spread, interleave};
use hypertexture::gpu::Gpu;
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture::{field, shape};
use serde::{Deserialize, Serialize};
use std::time::Instant;
use support::random::SplitMix;
use support::watchdog::own_processor_time;

/// All times of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bench {
    /// Device, machine and date.
    pub environment: Environment,
    /// Whether the device is the processor; its processor time is compared.
    pub on_processor: bool,
    /// The rows, in the order of the suite.
    pub rows: Vec<Timed>,
    /// Groups that could not be timed, with their errors.
    pub failures: Vec<String>,
    /// Whether it was interrupted.
    pub partial: bool,
}

impl Bench {
    /// A run on a device, without rows.
    pub fn here(gpu: &Gpu) -> Bench {
        Bench { environment: Environment::of(gpu), on_processor: gpu.info().cpu, ..Bench::default() }
    }
}

/// Times of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timed {
    /// Group, slash, name.
    pub name: String,
    /// Milliseconds on the device, by its timestamps; `None` if the device is not used.
    pub device_ms: Option<Spread>,
    /// Milliseconds of this process on all processors, user and system; `None` where the system does not report them.
    pub processor_ms: Option<Spread>,
    /// Milliseconds from scene to pixels in memory, wall clock, without compiling.
    pub wall_ms: Spread,
    /// Comparison with another row.
    pub against: Option<Against>,
    /// Time in the paper on a GeForce 6800 GT, milliseconds.
    pub paper_ms: Option<f64>,
}

impl Timed {
    pub(super) fn steadiest(&self, on_processor: bool) -> Spread {
        steadiest(on_processor, self.device_ms, self.processor_ms, self.wall_ms)
    }
}

/// The time that is compared with another run: of the processor if it is the device, as it is steady on a busy machine; else
/// of the device; else of the wall clock.
fn steadiest<T>(on_processor: bool, device: Option<T>, processor: Option<T>, wall: T) -> T {
    let [first, second] = if on_processor { [processor, device] } else { [device, processor] };
    first.or(second).unwrap_or(wall)
}

/// Ratio of the times of a row and another, by interleaved runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Against {
    /// Phrase for the other row.
    pub what: String,
    /// Time of this row divided by that of the other.
    pub times: Spread,
}

/// A run of a row, milliseconds.
#[derive(Clone, Copy)]
struct Run {
    device: Option<f64>,
    processor: Option<f64>,
    wall: f64,
}

impl Run {
    fn steadiest(&self, on_processor: bool) -> f64 {
        steadiest(on_processor, self.device, self.processor, self.wall)
    }
}

/// A row with its resources loaded.
enum Ready<'a> {
    Picture(Box<Scene>, Box<Renderer>),
    Field(&'a shape::Shape, &'a field::Request),
}

impl Ready<'_> {
    fn run(&mut self) -> Result<Run, RenderError> {
        let (start, before) = (Instant::now(), own_processor_time());
        let (device, compile_ms) = match self {
            Ready::Picture(scene, renderer) => {
                renderer.invalidate_shadows();
                let m = renderer.render(&**scene)?.measurements;
                (Some(m.device_ms()), m.compile_ms)
            }
            Ready::Field(shape, request) => {
                field::transform(shape, request, &|_| ())?;
                (None, 0.0)
            }
        };
        let taken = own_processor_time().zip(before).map(|(after, before)| after.saturating_sub(before));
        let processor = taken.map(|taken| taken.as_secs_f64() * 1e3);
        Ok(Run { device, processor, wall: start.elapsed().as_secs_f64() * 1e3 - compile_ms })
    }
}

/// Times groups of rows, each in turns, `repeats` times after a first run that compiles. If stopped, it returns the groups
/// that were timed. Errors of rows are part of the result.
pub fn measure(
    gpu: &Gpu,
    library: &Library,
    groups: &[Vec<Row>],
    repeats: usize,
    progress: &dyn Fn(f32),
    stop: &dyn Fn() -> bool,
) -> Bench {
    let mut bench = Bench::here(gpu);
    for (number, group) in groups.iter().enumerate() {
        match timed(gpu, library, group, repeats, bench.on_processor, stop) {
            Ok(Some(rows)) => bench.rows.extend(rows),
            Ok(None) => {
                bench.partial = true;
                break;
            }
            Err(failure) => bench.failures.push(failure),
        }
        progress((number + 1) as f32 / groups.len() as f32);
    }
    bench.environment.load_after = load();
    bench
}

/// Times a group in turns; `None` if it was stopped.
fn timed(
    gpu: &Gpu,
    library: &Library,
    group: &[Row],
    repeats: usize,
    on_processor: bool,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Vec<Timed>>, String> {
    let fails = |row: &Row| {
        let name = row.name.clone();
        move |error: RenderError| format!("{name}: {error}")
    };
    let mut ready = Vec::with_capacity(group.len());
    for row in group {
        let mut one = match &row.work {
            Work::Picture(scene) => {
                let subject = Subject::load(&**scene, library, &|_| ()).map_err(fails(row))?;
                Ready::Picture(scene.clone(), Box::new(Renderer::new(gpu, library, &subject)))
            }
            Work::Field(shape, request) => Ready::Field(shape, request),
        };
        if stop() {
            return Ok(None);
        }
        one.run().map_err(fails(row))?;
        ready.push(one);
    }
    let mut runs: Vec<Vec<Run>> = vec![Vec::new(); group.len()];
    for index in interleave(&vec![repeats; group.len()], &mut SplitMix(group.len() as u64)) {
        if stop() {
            return Ok(None);
        }
        runs[index].push(ready[index].run().map_err(fails(&group[index]))?);
    }
    let spread = |times: Option<Vec<f64>>| times.map(|times| Spread::of(&times));
    let against = |index: usize| {
        let (name, what) = group[index].against.as_ref()?;
        let other = group.iter().position(|row| row.name == *name)?;
        let times =
            runs[index].iter().zip(&runs[other]).map(|(a, b)| a.steadiest(on_processor) / b.steadiest(on_processor));
        Some(Against { what: (*what).into(), times: Spread::of(&times.collect::<Vec<_>>()) })
    };
    let timed = |(index, row): (usize, &Row)| Timed {
        name: row.name.clone(),
        device_ms: spread(runs[index].iter().map(|run| run.device).collect()),
        processor_ms: spread(runs[index].iter().map(|run| run.processor).collect()),
        wall_ms: Spread::of(&runs[index].iter().map(|run| run.wall).collect::<Vec<_>>()),
        against: against(index),
        paper_ms: row.paper_ms,
    };
    Ok(Some(group.iter().enumerate().map(timed).collect()))
}
