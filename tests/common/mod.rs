//! Shared by tests of pictures: a device under validation, scenes with a known answer, and the rays of a picture.

#![allow(dead_code, reason = "each file of tests uses its part of this")]

#[allow(unused_imports, reason = "each file of tests uses its part of this")]
pub use measure::cases::{Level, Ray, box_subject, homogeneous, rays};

use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::{Frame, Subject, render};
use hypertexture::scene::Scene;
use hypertexture::shader::{self, Library};
use measure::cases;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The device of the tests that run now, and how many they are. They share it: the layer of Debian 12 crashes where one
/// thread opens or closes a device while another one uses its own.
static SHARED: Mutex<Option<(Gpu, usize)>> = Mutex::new(None);

/// A test's part of the shared device.
struct Part(Option<Gpu>);

impl Part {
    fn shared() -> MutexGuard<'static, Option<(Gpu, usize)>> {
        SHARED.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn new() -> Part {
        let mut shared = Part::shared();
        let (gpu, tests) = shared.get_or_insert_with(|| {
            let device = std::env::var("HYPERTEXTURE_DEVICE").ok();
            let gpu = Gpu::new(&Options { device, validation: true, cache: None });
            (gpu.unwrap_or_else(|error| panic!("{error}; HYPERTEXTURE_NO_GPU=1 leaves these tests out")), 0)
        });
        *tests += 1;
        Part(Some(gpu.clone()))
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut shared = Part::shared();
        self.0 = None;
        *shared = shared.take().map(|(gpu, tests)| (gpu, tests - 1)).filter(|(_, tests)| *tests > 0);
    }
}

/// Runs a test on a device with validation, and fails on whatever the layer has reported until then: of this test, of those
/// that run beside it, and of the closing of the device behind the last of them.
pub fn with_gpu<T>(test: impl FnOnce(&Gpu) -> T) -> T {
    let part = Part::new();
    let gpu = part.0.as_ref().expect("it is there until the part ends");
    let messages = gpu.messages();
    let result = test(gpu);
    drop(part);
    let said = messages.take();
    assert!(said.is_empty(), "{} validation messages:\n{}", said.len(), said.join("\n"));
    result
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
