//! Times of rows, and the run that is saved.

use super::roofline::{Counts, Peaks};
use super::run::{Run, steadiest};
use super::suite::{Row, Work};
use crate::compare::report::{Environment, load};
use crate::compare::timing::{Spread, interleave};
use hypertexture::gpu::{Gpu, GpuError};
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture::{field, shape};
use hypertexture_support::random::SplitMix;
use serde::{Deserialize, Serialize};

/// All times of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bench {
    /// Device, machine and date.
    pub environment: Environment,
    /// Whether the device is the processor; its processor time is compared.
    pub on_processor: bool,
    /// Peaks of the device; `None` without pictures.
    #[serde(default)]
    pub peaks: Option<Peaks>,
    /// The rows, in the order of the suite.
    pub rows: Vec<Timed>,
    /// Rows that could not be timed, with their errors.
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
    /// Least time of its operations and fetches on this device; `None` where they are not counted.
    #[serde(default)]
    pub floor: Option<Floor>,
}

/// Least time of the work of a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Floor {
    /// The work.
    pub counts: Counts,
    /// Milliseconds of the device at its peak.
    pub ms: f64,
    /// Median time of the row without its shadow volume, divided by that.
    pub times: f64,
}

impl Timed {
    pub(super) fn steadiest(&self, on_processor: bool) -> Spread {
        steadiest(on_processor, self.device_ms, self.processor_ms, self.wall_ms)
    }
}

/// Ratio of the times of a row and another, by interleaved runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Against {
    /// Phrase for the other row.
    pub what: String,
    /// Time of this row divided by that of the other.
    pub times: Spread,
}

/// A row with its resources loaded.
enum Ready<'a> {
    Picture(Box<(Scene, Subject, Renderer)>),
    Field(&'a shape::Shape, &'a field::Request),
}

impl Ready<'_> {
    fn run(&mut self) -> Result<Run, RenderError> {
        match self {
            Ready::Picture(picture) => Run::of_picture(&mut picture.2, &picture.0),
            Ready::Field(shape, request) => Run::of_field(shape, request),
        }
    }

    /// Counts the work of a picture of so many fragments.
    fn counts(&self, gpu: &Gpu, library: &Library, fragments: Option<u64>) -> Result<Option<Counts>, RenderError> {
        match self {
            Ready::Picture(picture) => Counts::of(gpu, library, &picture.0, &picture.1, fragments),
            Ready::Field(..) => Ok(None),
        }
    }
}

/// Times groups of rows, each in turns, `repeats` times after a first run that compiles. If stopped, it returns the groups
/// that were timed. A row that fails is part of the result, and the others go on, on another device that `open` gives where
/// this one is lost.
pub fn measure(
    mut gpu: Gpu,
    open: &dyn Fn() -> Result<Gpu, GpuError>,
    library: &Library,
    groups: &[Vec<Row>],
    repeats: usize,
    progress: &dyn Fn(f32),
    stop: &dyn Fn() -> bool,
) -> Bench {
    let mut bench = Bench::here(&gpu);
    let mut failed = None;
    if groups.iter().flatten().any(|row| matches!(row.work, Work::Picture(_))) {
        match Peaks::of(&gpu, library) {
            Ok(peaks) => bench.peaks = Some(peaks),
            Err(error) => failed = Some(("peaks of the device".to_string(), error)),
        }
    }
    'groups: for (number, group) in groups.iter().enumerate() {
        let mut rows: Vec<&Row> = group.iter().collect();
        loop {
            if stop() {
                bench.partial = true;
                break 'groups;
            }
            if let Some((name, error)) = failed.take() {
                bench.failures.push(format!("{name}: {error}"));
                if matches!(&error, RenderError::Gpu(error) if error.is_lost()) {
                    match open() {
                        Ok(other) => gpu = other,
                        Err(error) => {
                            bench.failures.push(format!("all rows from {}: {error}", group[0].name));
                            break 'groups;
                        }
                    }
                }
            }
            match timed(&gpu, library, &rows, repeats, bench.peaks, stop) {
                Ok(Some(timed)) => break bench.rows.extend(timed),
                Ok(None) => {
                    bench.partial = true;
                    break 'groups;
                }
                Err((index, error)) => failed = Some((rows.remove(index).name.clone(), error)),
            }
        }
        progress((number + 1) as f32 / groups.len() as f32);
    }
    bench.environment.load_after = load();
    bench
}

/// Times rows in turns, and counts their work; `None` if it was stopped. An error comes with the place of its row.
fn timed(
    gpu: &Gpu,
    library: &Library,
    group: &[&Row],
    repeats: usize,
    peaks: Option<Peaks>,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Vec<Timed>>, (usize, RenderError)> {
    let on_processor = gpu.info().cpu;
    let mut ready = Vec::with_capacity(group.len());
    for (index, row) in group.iter().enumerate() {
        let mut one = match &row.work {
            Work::Picture(scene) => {
                let subject = Subject::load(&**scene, library, &|_| ()).map_err(|error| (index, error))?;
                let renderer = Renderer::new(gpu, library, &subject);
                Ready::Picture(Box::new(((**scene).clone(), subject, renderer)))
            }
            Work::Field(shape, request) => Ready::Field(shape, request),
        };
        if stop() {
            return Ok(None);
        }
        one.run().map_err(|error| (index, error))?;
        ready.push(one);
    }
    let mut runs: Vec<Vec<Run>> = vec![Vec::new(); group.len()];
    for index in interleave(&vec![repeats; group.len()], &mut SplitMix(group.len() as u64)) {
        if stop() {
            return Ok(None);
        }
        runs[index].push(ready[index].run().map_err(|error| (index, error))?);
    }
    let spread = |times: Option<Vec<f64>>| times.map(|times| Spread::of(&times));
    let times = |index: usize| runs[index].iter().map(|run| run.steadiest(on_processor)).collect::<Vec<_>>();
    let against = |index: usize| {
        let (names, what) = group[index].against.as_ref()?;
        let others = (0..group.len()).filter(|other| names.contains(&group[*other].name)).map(times);
        let fastest = others.min_by(|a, b| Spread::of(a).median.total_cmp(&Spread::of(b).median))?;
        let times = times(index).iter().zip(fastest).map(|(a, b)| a / b).collect::<Vec<_>>();
        Some(Against { what: (*what).into(), times: Spread::of(&times) })
    };
    let floor = |index: usize| {
        let (Some(peaks), Some(last)) = (peaks, runs[index].last()) else { return Ok(None) };
        let counts = ready[index].counts(gpu, library, last.fragments).map_err(|error| (index, error))?;
        let alone: Vec<f64> = runs[index].iter().map(|run| run.alone * run.steadiest(on_processor)).collect();
        let ms = |counts: Counts| counts.floor_ms(&peaks);
        Ok(counts.map(|counts| Floor { counts, ms: ms(counts), times: Spread::of(&alone).median / ms(counts) }))
    };
    let timed = |(index, row): (usize, &&Row)| {
        Ok(Timed {
            name: row.name.clone(),
            device_ms: spread(runs[index].iter().map(|run| run.device).collect()),
            processor_ms: spread(runs[index].iter().map(|run| run.processor).collect()),
            wall_ms: Spread::of(&runs[index].iter().map(|run| run.wall).collect::<Vec<_>>()),
            against: against(index),
            paper_ms: row.paper_ms,
            floor: floor(index)?,
        })
    };
    group.iter().enumerate().map(timed).collect::<Result<_, _>>().map(Some)
}

#[cfg(test)]
mod tests {
    use super::super::suite::library;
    use super::*;
    use hypertexture::gpu::Options;
    use hypertexture_support::faults;
    use hypertexture_support::validation_lock::ValidationLock;

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_row_that_loses_the_device_says_so_and_the_others_go_on() {
        let _lock = ValidationLock::acquire();
        faults::turn_on();
        let open = || {
            faults::lose(None);
            Gpu::new(&Options::from_env())
        };
        let row = |name: &str| {
            let mut scene = Scene::default();
            (scene.object.input, scene.image.size) = ("sphere".into(), [16; 2]);
            Row { name: name.into(), work: Work::Picture(Box::new(scene)), against: None, paper_ms: None }
        };
        let groups = [vec![row("first")], vec![row("lost"), row("third")], vec![row("fourth")]];
        let lose = |part: f32| {
            if part < 0.5 {
                faults::lose(Some("vkQueueSubmit2"));
            }
        };
        let bench = measure(open().unwrap(), &open, &library(), &groups, 2, &lose, &|| false);
        let names: Vec<&str> = bench.rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["first", "third", "fourth"]);
        assert!(bench.failures.len() == 1 && bench.failures[0].starts_with("lost: "), "{:?}", bench.failures);
        for floor in bench.rows.iter().map(|row| row.floor.unwrap()) {
            assert!(floor.ms > 0.0 && floor.times.is_finite() && floor.times > 0.0, "{floor:?}");
        }
    }
}
