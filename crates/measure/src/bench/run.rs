//! One run of a row.

use hypertexture::render::{Measurements, RenderError, Renderer};
use hypertexture::scene::Scene;
use hypertexture::{field, shape};
use hypertexture_support::watchdog::own_processor_time;
use std::time::Instant;

/// A run of a row, milliseconds.
#[derive(Clone, Copy)]
pub(super) struct Run {
    pub device: Option<f64>,
    pub processor: Option<f64>,
    pub wall: f64,
    /// Part of the time on the device without the shadow volume.
    pub alone: f64,
    /// Fragments of a picture, if the device counts them.
    pub fragments: Option<u64>,
}

impl Run {
    /// Draws a picture, with its shadow volume.
    pub(crate) fn of_picture(renderer: &mut Renderer, scene: &Scene) -> Result<Run, RenderError> {
        renderer.invalidate_shadows();
        Run::of(|| Ok(Some(renderer.render(scene)?.measurements)))
    }

    /// Computes a field.
    pub fn of_field(shape: &shape::Shape, request: &field::Request) -> Result<Run, RenderError> {
        Run::of(|| Ok(field::transform(shape, request, &|_| ()).map(|_| None)?))
    }

    fn of(work: impl FnOnce() -> Result<Option<Measurements>, RenderError>) -> Result<Run, RenderError> {
        let (start, before) = (Instant::now(), own_processor_time());
        let drawn = work()?;
        let taken = own_processor_time().zip(before).map(|(after, before)| after.saturating_sub(before));
        let compile_ms = drawn.as_ref().map_or(0.0, |drawn| drawn.compile_ms);
        Ok(Run {
            device: drawn.as_ref().map(Measurements::device_ms),
            processor: taken.map(|taken| taken.as_secs_f64() * 1e3),
            wall: start.elapsed().as_secs_f64() * 1e3 - compile_ms,
            alone: drawn.as_ref().map_or(1.0, |drawn| drawn.gpu_ms / drawn.device_ms()),
            fragments: drawn.and_then(|drawn| drawn.fragments),
        })
    }

    /// The time that is compared.
    pub(crate) fn steadiest(&self, on_processor: bool) -> f64 {
        steadiest(on_processor, self.device, self.processor, self.wall)
    }
}

/// The time that is compared with another run: of the processor if it is the device, as it is steady on a busy machine; else
/// of the device; else of the wall clock.
pub(super) fn steadiest<T>(on_processor: bool, device: Option<T>, processor: Option<T>, wall: T) -> T {
    let [first, second] = if on_processor { [processor, device] } else { [device, processor] };
    first.or(second).unwrap_or(wall)
}
