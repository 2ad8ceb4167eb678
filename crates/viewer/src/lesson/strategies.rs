//! Four ways to get turbulence, each with its picture, its time and its error.

use crate::background::{Background, Notify};
use crate::worker::LoadedScene;
use hypertexture::gpu::Gpu;
use hypertexture::render::{RenderError, Renderer};
use hypertexture::scene::{Pass, Scene};
use hypertexture_measure::compare::candidates::Sweep;
use hypertexture_measure::compare::{Row, Session, Settings, compare};
use hypertexture_measure::reference::reference;
use std::sync::Arc;
use std::task::Poll;

/// Modules of turbulence, and the source of each in words.
pub(super) const WAYS: [(&str, &str); 4] = [
    ("procedural", "Every octave computed in the shader (MJ 4.2)."),
    ("lookups8", "One lookup in a block of noise for each octave (MJ 4.1)."),
    ("channels", "Four octaves in the channels of each lookup (MJ 4.1)."),
    ("encoded", "The whole sum precomputed: one lookup (MJ 4.1)."),
];
/// Longest side of the pictures, pixels. Higher: references take longer.
const SIDE: u32 = 64;
/// Tolerance of a reference. Lower: slower; errors below it mean nothing.
const TOLERANCE: f64 = 2e-3;
/// Timed runs of each way.
const RUNS: usize = 5;

/// A way that was measured.
pub(super) struct Measured {
    pub(super) way: String,
    /// Its source, in words.
    pub(super) about: &'static str,
    /// Milliseconds: of the processor if that is the device, else on the device.
    pub(super) ms: f64,
    /// Root mean square error against the f64 reference of its own noise, linear light.
    pub(super) rmse: f64,
    /// Octaves that it has, of those of the scene.
    pub(super) octaves: Option<[u32; 2]>,
    /// Premultiplied linear RGBA.
    pub(super) pixels: Vec<[f32; 4]>,
    pub(super) size: [u32; 2],
}

/// The measured ways, and the measurement in progress.
#[derive(Default)]
pub(super) struct Strategies {
    pub(super) running: Option<Background<Result<Measured, String>>>,
    pub(super) found: Vec<Result<Measured, String>>,
}

impl Strategies {
    /// Starts the measurement.
    pub(super) fn start(&mut self, gpu: &Gpu, variant: &LoadedScene, notify: &Notify) {
        let (gpu, variant) = (gpu.clone(), variant.clone());
        self.found.clear();
        self.running = Some(Background::start(notify, move |task| {
            let stop = || task.is_cancelled();
            match measured(&gpu, &variant, &stop, &|done| task.report(done)) {
                Ok(ways) => ways.into_iter().for_each(|way| task.send(way)),
                Err(reason) => task.send(Err(reason)),
            }
        }));
    }

    /// Receives ways.
    pub(super) fn poll(&mut self) {
        while let Some(Poll::Ready(found)) = self.running.as_ref().map(Background::poll) {
            match found {
                Some(way) => self.found.push(way),
                None => self.running = None,
            }
        }
    }
}

fn measured(
    gpu: &Gpu,
    variant: &LoadedScene,
    stop: &(dyn Fn() -> bool + Sync),
    progress: &dyn Fn(f32),
) -> Result<Vec<Result<Measured, String>>, String> {
    let LoadedScene { scene, library, subject } = variant;
    let small = reduced(scene);
    let samples = Some(vec![small.quality.samples]);
    let strategies = Some(WAYS.map(|(way, _)| way.into()).to_vec());
    let settings = Settings { sweep: Sweep { quick: true, samples, strategies, filters: false }, repeat: RUNS };
    let session = Session { gpu, library, subject, worker: None, stop };
    let mut truth = |scene: &Scene| {
        let found = reference(library, scene, subject, TOLERANCE, &|_| (), stop);
        found.map(Arc::new).map_err(|error| error.to_string())
    };
    let found =
        compare(session, &small, &settings, &mut truth, &|_| (), progress).map_err(|error| error.to_string())?;
    let failures = found.failures.iter().map(|failure| Err(format!("{}: {}", failure.label, failure.message)));
    let rows =
        WAYS.iter().filter_map(|(way, about)| Some((found.rows.iter().find(|row| is_of(row, way, &small))?, *about)));
    let picture = |(row, about): (&Row, &'static str)| -> Result<Measured, RenderError> {
        let scene = &row.candidate.scene;
        let frame = Renderer::new(gpu, library, subject).render(scene)?;
        let (way, size) = (scene.effect.turbulence.clone(), scene.image.size);
        let (ms, rmse) = row.point();
        Ok(Measured { way, about, ms, rmse, octaves: row.candidate.octaves(), pixels: frame.pixels, size })
    };
    Ok(rows.map(|row| picture(row).map_err(|error| error.to_string())).chain(failures).collect())
}

/// Whether a row draws a way by rays and points, with the noise of the scene.
fn is_of(row: &Row, way: &str, scene: &Scene) -> bool {
    let (own, curve) = (&row.candidate.scene, row.candidate.curve());
    let is_plain = curve.pass == Pass::March && curve.integration == scene.quality.integration && !row.candidate.aside;
    is_plain && own.effect.turbulence == way && own.effect.noise == scene.effect.noise
}

/// The scene as a small picture of single rays. Its turbulence is outside of the ways, since a comparison also tries other
/// passes of the scene's own one.
fn reduced(scene: &Scene) -> Scene {
    let mut small = scene.clone();
    let longer = scene.image.size.into_iter().max().unwrap_or(SIDE).max(SIDE);
    small.image.size = scene.image.size.map(|side| (side * SIDE / longer).max(1));
    small.quality.supersampling = 1;
    small.quality.integration = Default::default();
    small.effect.turbulence = "octaves".into();
    small
}
