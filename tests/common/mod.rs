//! Shared by tests of pictures: a device under validation, scenes with a known answer, and the rays of a picture.

#![allow(dead_code, reason = "each file of tests uses its part of this")]

#[allow(unused_imports, reason = "each file of tests uses its part of this")]
pub use hypertexture_measure::cases::{Level, Ray, box_subject, homogeneous, rays};

use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::{Frame, Subject, render};
use hypertexture::scene::Scene;
use hypertexture::shader::{self, Library};
use hypertexture_measure::cases;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The devices of the tests that run now, and how many tests use each. Tests share them: the layer of Debian 12 crashes where
/// one thread opens or closes a device while another one uses its own. Several, since a driver on the processor compiles the
/// shaders of a device by one thread.
static SHARED: Mutex<Vec<(Gpu, usize)>> = Mutex::new(Vec::new());

/// A test's part of the shared devices.
struct Part {
    gpus: Vec<Gpu>,
    /// Which of the shared devices these are.
    places: Range<usize>,
}

impl Part {
    fn shared() -> MutexGuard<'static, Vec<(Gpu, usize)>> {
        SHARED.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The device with the fewest tests, or all of them.
    fn new(wants_all: bool) -> Part {
        let mut shared = Part::shared();
        if shared.is_empty() {
            let options = Options { device: std::env::var("HYPERTEXTURE_DEVICE").ok(), validation: true, cache: None };
            let first = Gpu::new(&options);
            let first = first.unwrap_or_else(|error| panic!("{error}; HYPERTEXTURE_NO_GPU=1 leaves these tests out"));
            let gpus = cases::devices(first, &options).unwrap_or_else(|error| panic!("{error}"));
            *shared = gpus.into_iter().map(|gpu| (gpu, 0)).collect();
        }
        let idle = (0..shared.len()).min_by_key(|&place| shared[place].1).expect("a device is open");
        let places = if wants_all { 0..shared.len() } else { idle..idle + 1 };
        shared[places.clone()].iter_mut().for_each(|(_, tests)| *tests += 1);
        Part { gpus: shared[places.clone()].iter().map(|(gpu, _)| gpu.clone()).collect(), places }
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut shared = Part::shared();
        self.gpus.clear();
        shared[self.places.clone()].iter_mut().for_each(|(_, tests)| *tests -= 1);
        if shared.iter().all(|(_, tests)| *tests == 0) {
            shared.clear();
        }
    }
}

/// Runs a test on a device with validation, and fails on whatever the layer has reported until then: of this test, of those
/// that run beside it, and of the closing of the devices behind the last of them.
pub fn with_gpu<T>(test: impl FnOnce(&Gpu) -> T) -> T {
    on(Part::new(false), |gpus| test(&gpus[0]))
}

/// Runs a test on all devices, as [`with_gpu`] does on one.
pub fn with_gpus<T>(test: impl FnOnce(&[Gpu]) -> T) -> T {
    on(Part::new(true), test)
}

fn on<T>(part: Part, test: impl FnOnce(&[Gpu]) -> T) -> T {
    let messages: Vec<_> = part.gpus.iter().map(Gpu::messages).collect();
    let result = test(&part.gpus);
    drop(part);
    let said: Vec<String> = messages.iter().flat_map(|messages| messages.take()).collect();
    assert!(said.is_empty(), "{} validation messages:\n{}", said.len(), said.join("\n"));
    result
}

/// Whether long tests run whole, as they do before a merge, and not in their short form.
pub fn is_whole() -> bool {
    std::env::var_os("HYPERTEXTURE_WHOLE").is_some_and(|value| !value.is_empty() && value != "0")
}

/// The subject of a scene whose object is a formula.
pub fn formula(scene: &Scene) -> Subject {
    subject(scene, &shader::shipped())
}

/// The subject of a scene.
pub fn subject(scene: &Scene, library: &Library) -> Subject {
    Subject::load(scene, library, &|_| {}).unwrap_or_else(|error| panic!("{error}"))
}

/// Renders a scene that must render.
pub fn picture(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> Frame {
    render(gpu, library, scene, subject).unwrap_or_else(|error| panic!("{error}"))
}

/// Renders with each number of samples and compares a channel with what `expected` says of a ray, as
/// [`cases::levels`] does. Prints the table.
pub fn errors(
    gpu: &Gpu,
    library: &Library,
    (scene, subject): (&Scene, &Subject),
    samples: &[u32],
    channel: usize,
    expected: impl Fn(&Ray) -> Option<f64>,
) -> Vec<Level> {
    let known = rays(scene, subject).iter().filter(|ray| expected(ray).is_some()).count();
    assert!(known > 100, "only {known} rays have a known answer");
    let levels = cases::levels(gpu, library, scene, subject, samples, channel, expected);
    let levels = levels.unwrap_or_else(|error| panic!("{error}"));
    println!("{:?}\n    N  max error  mean error", scene.camera.projection);
    levels.iter().for_each(|row| println!("{:5}  {:.3e}   {:.3e}", row.samples, row.max, row.mean));
    levels
}

/// Largest and root-mean-square difference of two pictures, over all channels.
pub fn difference(a: &Frame, b: &Frame) -> (f64, f64) {
    assert_eq!(a.size, b.size);
    let channels = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let (max, sum) =
        channels.map(|(a, b)| f64::from(a - b).abs()).fold((0.0f64, 0.0), |(m, s), d| (m.max(d), s + d * d));
    (max, (sum / (4 * a.pixels.len()) as f64).sqrt())
}
