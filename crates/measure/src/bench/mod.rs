//! What scenes cost on a device: pictures and fields that are timed in turns, and what got slower since a saved run.
//!
//! Role: [`suite()`] lists the rows, [`measure`] times them, [`Bench`] is what is written, read again and held against
//! another. Invariant: a ratio is of times of one run whose repeats were made side by side; nothing is dropped.

mod report;
mod suite;

pub use report::{Change, Mismatch, changes, table};
pub use suite::{Row, Work, library, suite};

use super::compare::report::{Environment, load};
use super::compare::timing::{Spread, interleave};
use hypertexture::gpu::Gpu;
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture::{field, shape};
use serde::{Deserialize, Serialize};
use std::time::Instant;
use support::random::SplitMix;
use support::watchdog::own_processor_time;

/// All that was timed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bench {
    /// Where and when.
    pub environment: Environment,
    /// Whether the device is the processor, so that its time counts.
    pub on_processor: bool,
    /// The rows, in the order of the suite.
    pub rows: Vec<Timed>,
    /// Rows that could not be timed, and why.
    pub failures: Vec<String>,
    /// Whether it was interrupted.
    pub partial: bool,
}

impl Bench {
    /// Of this device, with nothing timed yet.
    pub fn here(gpu: &Gpu) -> Bench {
        Bench { environment: Environment::of(gpu), on_processor: gpu.info().cpu, ..Bench::default() }
    }
}

/// What a row took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timed {
    /// Name of the row: its group, a slash, and what it is there.
    pub name: String,
    /// Milliseconds on the device, by its timestamps; `None` of what the device has no part in.
    pub device_ms: Option<Spread>,
    /// Milliseconds of this process on all processors, user and system; `None` where the system does not say.
    pub processor_ms: Option<Spread>,
    /// Milliseconds from scene to pixels in memory, wall clock, without compiling.
    pub wall_ms: Spread,
    /// What the row is held against.
    pub against: Option<Against>,
    /// What the paper prints for a GeForce 6800 GT, milliseconds.
    pub paper_ms: Option<f64>,
}

impl Timed {
    fn steadiest(&self, on_processor: bool) -> Spread {
        steadiest(on_processor, self.device_ms, self.processor_ms, self.wall_ms)
    }
}

/// What is compared with another run: time of the processor where that is the device, for it is steady on a busy machine;
/// else of the device; else of the wall.
fn steadiest<T>(on_processor: bool, device: Option<T>, processor: Option<T>, wall: T) -> T {
    let [first, second] = if on_processor { [processor, device] } else { [device, processor] };
    first.or(second).unwrap_or(wall)
}

/// How many times as long a row takes as another, by runs made side by side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Against {
    /// What the other is to it.
    pub what: String,
    /// Time of this row by that of the other.
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

/// A row that is ready to be run.
enum Ready<'a> {
    Picture(Box<Scene>, Box<Renderer>),
    Field(&'a shape::Shape, &'a field::Request),
}

impl Ready<'_> {
    fn run(&mut self) -> Result<Run, RenderError> {
        let (start, before) = (Instant::now(), own_processor_time());
        let (device, compile_ms) = match self {
            Ready::Picture(scene, renderer) => {
                renderer.forget_shadows();
                let m = renderer.render(scene)?.measurements;
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

/// Times groups of rows, each in turns, `repeats` times after a first run that compiles. Stopped, it keeps the groups that
/// were timed. What goes wrong with one row is told in the result.
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

/// A group in turns; `None` where it was stopped.
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
                let subject = Subject::load(scene, library, &|_| ()).map_err(fails(row))?;
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
