//! Pictures during a stroke of the brush: only the part that its touches change is drawn anew. Whole pictures would be
//! coarse, since a stroke leaves no time for proofs of empty cells. Shadows that the touches cast on other parts follow
//! when the stroke rests.

use super::job::{Job, Picture};
use super::mean::resampled;
use super::render_thread::{Accumulation, RenderThread};
use super::renderers::{VariantRenderers, pose_of};
use super::status::Stage;
use crate::document::painting::Touch;
use hypertexture::glam::{Vec2, Vec3};
use hypertexture::gpu::Area;
use hypertexture::render::{RenderError, ViewPose, paste_areas};
use hypertexture::scene::{RayPath, Scene};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Least depth in front of the eye at which a part of the picture is known, object units.
const MIN_DEPTH: f32 = 1e-2;
/// Step of the coarsest groom, object units, for a groom that is gone.
const MAX_VOXEL: f32 = 2.25 / 32.0;

/// A part of a picture: left and top, right and bottom, in fractions of its width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    low: Vec2,
    high: Vec2,
}

impl Part {
    /// The part that shows all places within `reach` of touches; `None` if a place is not in front of the eye.
    fn of(touches: &[Touch], reach: f32, pose: &ViewPose) -> Option<Part> {
        let (eye, along) = pose.ray([0.0; 2]);
        let mut part = Part { low: Vec2::ONE, high: Vec2::ZERO };
        for (at, radius) in touches.iter().flat_map(Touch::places) {
            for corner in 0..8u8 {
                let sign = |axis: u8| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                let place = at + (radius + reach) * Vec3::new(sign(0), sign(1), sign(2));
                let on_screen = 0.5 * (Vec2::from(pose.place(place)) + Vec2::ONE);
                if (place - eye).dot(along) < MIN_DEPTH || !on_screen.is_finite() {
                    return None;
                }
                part = Part { low: part.low.min(on_screen), high: part.high.max(on_screen) };
            }
        }
        Some(part)
    }

    /// The pixels of this part and around it, with even ends; `None` if the part is beside the picture.
    fn area(&self, [width, height]: [u32; 2]) -> Option<Area> {
        let range = |low: f32, high: f32, side: u32| {
            let start = (low.max(0.0) * side as f32) as u32;
            let end = ((high.max(0.0) * side as f32) as u32).saturating_add(2);
            let range = start.saturating_sub(1) & !1..end.next_multiple_of(2).min(side);
            (high > 0.0 && low < 1.0 && !range.is_empty()).then_some(range)
        };
        let columns = range(self.low.x, self.high.x, width)?;
        Some(Area { columns, rows: range(self.low.y, self.high.y, height)? })
    }
}

/// Pastes an enlarged area of a picture of size `from` into one of size `to`.
fn paste_enlarged(pixels: &[[f32; 4]], area: &Area, from: [u32; 2], to: [u32; 2], into: &mut [[f32; 4]]) {
    let [columns, rows] = [&area.columns, &area.rows];
    // Whole numbers, so that the last column of one is that of the other.
    let scaled = |range: &std::ops::Range<u32>, axis: usize| {
        let [from, to] = [from[axis], to[axis]].map(u64::from);
        let [start, end] = [range.start, range.end].map(u64::from);
        (start * to).div_ceil(from) as u32..(end * to / from) as u32
    };
    let large = Area { columns: scaled(columns, 0), rows: scaled(rows, 1) };
    let size = [large.columns.len() as u32, large.rows.len() as u32];
    let place = |at: [f32; 2]| {
        let [first, start] = [[large.columns.start, large.rows.start], [columns.start, rows.start]];
        let own = [columns.len() as f32, rows.len() as f32];
        [0, 1].map(|axis| {
            let full = (first[axis] as f32 + at[axis] * size[axis] as f32) / to[axis] as f32;
            ((full * from[axis] as f32 - start[axis] as f32) / own[axis]).clamp(0.0, 1.0)
        })
    };
    let enlarged = resampled(pixels, [columns.len() as u32, rows.len() as u32], size, place, [0.0; 4]);
    paste_areas(&enlarged, &[large], to[0], into);
}

impl RenderThread {
    /// The picture of `before` with the part drawn anew that a stroke has changed since; `None` if more has changed, if the
    /// scene shows a touched place elsewhere, or if whole previews are as fine as the scene's own picture.
    pub(super) fn repainted(
        &mut self,
        job: &Job,
        renderers: &mut [VariantRenderers],
        before: &Accumulation,
    ) -> Result<Option<Accumulation>, RenderError> {
        let ([variant], [renderers_of], [own]) = (&job.variants[..], renderers, &before.scenes[..]) else {
            return Ok(None);
        };
        let scene = &variant.scene;
        let touches = job.trace.as_ref().and_then(|trace| trace.between(own.groom.as_deref(), scene.groom.as_deref()));
        let is_moved = !scene.effect.warp.is_empty() || scene.effect.ray_path != RayPath::Straight;
        let needs_whole = self.budget.level().is_finest() || scene.is_half_angle() || is_moved;
        let (false, Some(touches)) = (needs_whole, touches) else { return Ok(None) };
        if (Scene { groom: own.groom.clone(), ..Scene::clone(scene) }) != **own {
            return Ok(None);
        }
        let parameters = scene.check(&variant.library).ok();
        let outer = parameters.and_then(|own| own.outer_iso()).unwrap_or(scene.object.outer_iso);
        let pose = pose_of(variant)?;
        // A lookup reads the next voxel, and a slope of the groom the one behind it.
        let voxels = 2.0 * variant.subject.groom.as_ref().map_or(MAX_VOXEL, |groom| groom.step());
        let Some(part) = Part::of(touches, outer + voxels, &pose) else { return Ok(None) };
        let (mut pictures, from) = before.best();
        let size = scene.image.size;
        if from != size {
            pictures.iter_mut().for_each(|pixels| *pixels = resampled(pixels, from, size, |at| at, [0.0; 4]));
        }
        let mut picture = Picture::of(job, Stage::Coarse, 0.0);
        self.shared.wait_until_shown();
        if let Some(area) = part.area(size) {
            let share = area.columns.len() as f64 * area.rows.len() as f64 / (f64::from(size[0]) * f64::from(size[1]));
            let Some(drawn) = self.draw_part(scene, renderers_of, part, share, &mut pictures[0])? else {
                return Ok(None);
            };
            (picture.gpu_ms, picture.samples) = drawn;
        }
        let mut accumulation = Accumulation::of(job, vec![pose], pictures, size);
        accumulation.gpu_ms = picture.gpu_ms;
        self.shared.reported.store(job.number, Ordering::Relaxed);
        self.send_picture(job, &accumulation, &accumulation.coarse, picture);
        Ok(Some(accumulation))
    }

    /// Draws a part of a picture into `pixels`, as fine as the budget allows; returns the milliseconds on the device and
    /// the samples of a ray, or `None` if the thread ends.
    fn draw_part(
        &mut self,
        scene: &Scene,
        renderers_of: &mut VariantRenderers,
        part: Part,
        share: f64,
        pixels: &mut [[f32; 4]],
    ) -> Result<Option<(f64, u32)>, RenderError> {
        loop {
            let (start, level) = (Instant::now(), self.strokes.level(scene, share));
            let (coarse, work) = (renderers_of.stroke_preview(scene, level), level.stroke_work(scene, share));
            let Some(area) = part.area(coarse.image.size) else { return Ok(Some((0.0, coarse.quality.samples))) };
            let (ends, shared) = (self.strokes.ends(level), self.shared.clone());
            renderers_of.own.stop_where(move |ms| shared.quits() || ends(ms));
            match renderers_of.own.render_areas(&coarse, std::slice::from_ref(&area), None) {
                Ok(frame) => {
                    paste_enlarged(&frame.pixels, &area, coarse.image.size, scene.image.size, pixels);
                    let device_ms = frame.measurements.device_ms();
                    let ms = start.elapsed().as_secs_f64() * 1e3 - frame.measurements.compile_ms;
                    log::debug!("stroke {area:?} of {:?}: {device_ms:.1} ms of {ms:.1} ms", coarse.image.size);
                    self.strokes.took(work, device_ms, (ms - device_ms).max(0.0));
                    return Ok(Some((device_ms, frame.measurements.slices)));
                }
                Err(RenderError::Stopped) if self.shared.quits() => return Ok(None),
                Err(RenderError::Stopped) => self.strokes.gave_up(work),
                Err(error) => return Err(error),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_area_holds_its_part_and_has_even_ends() {
        let part = |low: [f32; 2], high: [f32; 2]| Part { low: low.into(), high: high.into() }.area([101, 81]);
        let area = part([0.25, -0.5], [0.5, 0.251]).unwrap();
        assert_eq!((area.columns, area.rows), (24..52, 0..22));
        assert_eq!(part([0.9; 2], [2.0; 2]).unwrap().columns, 88..101);
        assert_eq!(part([1.2, 0.0], [1.5, 1.0]), None);
        assert_eq!(part([1.0; 2], [0.0; 2]), None, "no touches");
    }

    #[test]
    fn an_enlarged_area_has_its_place_in_the_picture() {
        // A ramp to the right in a picture of 20 x 10 pixels, of which an area is pasted into one of 80 x 40.
        let area = Area { columns: 4..12, rows: 2..6 };
        let ramp = |x: u32| [(x as f32 + 0.5) / 20.0; 4];
        let pixels: Vec<[f32; 4]> = (0..4).flat_map(|_| (4..12).map(ramp)).collect();
        let mut into = vec![[-1.0; 4]; 80 * 40];
        paste_enlarged(&pixels, &area, [20, 10], [80, 40], &mut into);
        for (index, pixel) in into.iter().enumerate() {
            let [x, y] = [index % 80, index / 80];
            if !(16..48).contains(&x) || !(8..24).contains(&y) {
                assert_eq!(*pixel, [-1.0; 4], "{x} {y}");
            } else if (18..46).contains(&x) {
                assert!((pixel[0] - (x as f32 + 0.5) / 80.0).abs() < 1e-4, "{x} {y}: {pixel:?}");
            }
        }
    }
}
