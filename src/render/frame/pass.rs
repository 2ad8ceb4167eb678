//! The two passes: view-aligned slices, and rays.
//!
//! Role: draws slices in equidistant planes that are fixed in eye space, or marches rays through the same samples.
//! Invariant: the vertices depend on the camera's distance and on the size of the scene, never on the rotation (MJ
//! 3.3). Source: MJ 2, 3.3, 3.6 and Fig. 1; GG 39.6.1.

use super::submission_budget::SubmissionControl;
use crate::gpu::{Area, BindSet, Buffer, Commands, Gpu, GpuError, Image, Load, Pipeline, Submitted, Target};
use crate::render::camera::SlicePlanes;
use crate::render::cells::Tiles;
use crate::render::error::RenderError;
use crate::scene::{Order, Proxy};
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

/// Vertices of a stack of slices.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Vertices in drawing order.
    pub vertices: Vec<f32>,
    /// Vertices of one slice.
    pub per_slice: u32,
    /// Number of slices.
    pub slices: u32,
}

/// Builds a slice in each plane: quads as wide as the sphere, or polygons that the vertex stage clips to the box.
/// `tint` maps the place in the stack, from 0 at the camera to 1, to linear RGBA.
pub fn stack(planes: &SlicePlanes, radius: f32, proxy: Proxy, order: Order, tint: impl Fn(f32) -> [f32; 4]) -> Stack {
    let mut drawn: Vec<u32> = (0..planes.count).collect();
    if order == Order::BackToFront {
        drawn.reverse();
    }
    let mut vertices = Vec::new();
    for &plane in &drawn {
        let (z, place) = (-planes.depth(plane), (plane + planes.skipped) as f32 + 0.5);
        let tint = tint(place / (planes.count + planes.skipped) as f32);
        match proxy {
            Proxy::Quads => {
                for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    let position = [x * radius, y * radius, z];
                    vertices.extend(position.into_iter().chain(position).chain(tint));
                }
            }
            Proxy::Polygons => {
                for corner in [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5] {
                    vertices.extend([corner as f32, z].into_iter().chain(tint));
                }
            }
        }
    }
    let per_slice = match proxy {
        Proxy::Quads => 6,
        Proxy::Polygons => 12,
    };
    Stack { vertices, per_slice, slices: planes.count }
}

/// Floats of each vertex attribute of a stack.
pub fn attributes(proxy: Proxy) -> &'static [u32] {
    match proxy {
        Proxy::Quads => &[3, 3, 4],
        Proxy::Polygons => &[2, 4],
    }
}

/// Timing of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTiming {
    /// Time of the first use of the pipeline, when some drivers compile it, milliseconds.
    pub first_use_ms: f64,
    /// Time on the device, milliseconds.
    pub gpu_ms: f64,
    /// Longest submission, milliseconds.
    pub longest_ms: f64,
    /// Shaded fragments, if the device counts them.
    pub fragments: Option<u64>,
}

impl PassTiming {
    /// Warms the pipeline up with a row of the first triangle.
    fn begin(
        gpu: &Gpu,
        pipeline: &Pipeline,
        set: &BindSet,
        vertices: Option<&Buffer>,
        into: Target<'_>,
    ) -> Result<PassTiming, GpuError> {
        let area = Area { columns: 0..1, rows: 0..1 };
        let cost = gpu.submit("first use", |commands| {
            if pipeline.is_compute() {
                return commands.dispatch(pipeline, set, into.color, &[area]);
            }
            commands.render(into, Load::Clear([0.0; 4]), |draw| {
                draw.within(&area);
                draw.triangles(pipeline, set, vertices, 0..3);
            });
        })?;
        Ok(PassTiming { first_use_ms: cost.wall_ms, fragments: Some(0), ..Default::default() })
    }

    /// Adds the timing of a following pass.
    pub fn append(&mut self, next: &PassTiming) {
        self.first_use_ms += next.first_use_ms;
        self.gpu_ms += next.gpu_ms;
        self.longest_ms = self.longest_ms.max(next.longest_ms);
        self.fragments = self.fragments.zip(next.fragments).map(|(a, b)| a + b);
    }

    fn add(&mut self, cost: &Submitted) {
        self.gpu_ms += cost.gpu_ms;
        self.longest_ms = self.longest_ms.max(cost.gpu_ms);
        self.fragments = self.fragments.zip(cost.fragments).map(|(a, b)| a + b);
    }
}

/// Marches a ray of `samples` through each pixel of the areas, one area after the other, in submissions within the
/// budget. The quads of the areas must not overlap. Other pixels are 0 afterwards; those of an area do not depend on the
/// other areas. Whole quads are drawn: bent rays read their neighbors' directions, which lavapipe (Mesa
/// 25) does not compute outside a scissor.
///
/// # Errors
/// Those of a submission; [`RenderError::Stopped`].
pub fn march(
    gpu: &Gpu,
    pipeline: &Pipeline,
    set: &BindSet,
    (areas, samples): (&[Area], u32),
    target: Target<'_>,
    control: &mut SubmissionControl<'_>,
) -> Result<PassTiming, RenderError> {
    let into = Target { resolved: None, ..target };
    let mut drawn = if control.budget.begin() {
        PassTiming::begin(gpu, pipeline, set, None, into)?
    } else {
        PassTiming { fragments: Some(0), ..Default::default() }
    };
    drawn.fragments = drawn.fragments.filter(|_| !pipeline.is_compute());
    let mut load = Load::Clear([0.0; 4]);
    let mut left: VecDeque<Area> = areas.iter().map(Area::quads).collect();
    let (all, mut done) = (left.iter().map(Area::pixels).sum::<u64>().max(1) as f32, 0);
    let samples = f64::from(samples.max(1));
    while load != Load::Keep || !left.is_empty() {
        control.check(drawn.gpu_ms, done as f32 / all)?;
        let taken = take(&mut left, (control.budget.samples() / samples) as u64);
        let cost = gpu.submit("rays", |commands| {
            if pipeline.is_compute() {
                if load != Load::Keep {
                    commands.render(into, load, |_| ());
                }
                return commands.dispatch(pipeline, set, into.color, &taken);
            }
            commands.render(into, load, |draw| {
                for area in &taken {
                    draw.within(area);
                    draw.triangles(pipeline, set, None, 0..3);
                }
            });
        })?;
        drawn.add(&cost);
        if !taken.is_empty() {
            let pixels = taken.iter().map(Area::pixels).sum::<u64>();
            control.budget.took(pixels as f64 * samples, cost.gpu_ms);
            done += pixels;
        }
        load = Load::Keep;
    }
    if target.resolved.is_some() {
        gpu.submit("resolve", |commands| commands.render(target, load, |_| ()))?;
    }
    Ok(drawn)
}

/// Removes the next rows of quads from the areas: about `count` pixels, at least one row of quads, or the rest.
fn take(areas: &mut VecDeque<Area>, count: u64) -> Vec<Area> {
    let (mut taken, mut left) = (Vec::new(), count.max(1));
    while left > 0
        && let Some(Area { columns, rows }) = areas.pop_front()
    {
        let wanted = (left / columns.len() as u64).max(1);
        if wanted == 1 && !taken.is_empty() && left < columns.len() as u64 {
            areas.push_front(Area { columns, rows });
            break;
        }
        let wanted = wanted.next_multiple_of(2).min(u32::MAX.into()) as u32;
        let end = rows.end.min(rows.start.saturating_add(wanted));
        if end < rows.end {
            areas.push_front(Area { columns: columns.clone(), rows: end..rows.end });
        }
        let own = Area { columns, rows: rows.start..end };
        left = left.saturating_sub(own.pixels());
        taken.push(own);
    }
    taken
}

/// Half-angle light, advanced by a triangle for each slice.
pub struct Light<'a> {
    /// Draws the light behind a slice from the light before it.
    pub pipeline: &'a Pipeline,
    /// Inputs with the light in the first buffer, and in the second.
    pub sets: [BindSet; 2],
    /// Three vertices for each slice.
    pub vertices: &'a Buffer,
    /// The alternating buffers.
    pub buffers: &'a [Arc<Image>; 2],
}

impl Light<'_> {
    fn into(&self, buffer: usize) -> Target<'_> {
        Target::of(&self.buffers[buffer])
    }

    /// Fills the first buffers with full light, and warms the pipeline up.
    fn begin(&self, gpu: &Gpu) -> Result<f64, GpuError> {
        let cost = gpu.submit("first light", |commands| {
            for buffer in [0, 1] {
                commands.render(self.into(buffer), Load::Clear([1.0; 4]), |_| ());
                commands.sample(&self.buffers[buffer]);
            }
            self.pass(commands, 0);
        })?;
        Ok(cost.wall_ms)
    }

    /// Draws the light behind a slice.
    fn pass(&self, commands: &mut Commands<'_>, slice: u32) {
        let before = slice as usize % 2;
        commands.render(self.into(1 - before), Load::Clear([1.0; 4]), |draw| {
            draw.triangles(self.pipeline, &self.sets[before], Some(self.vertices), 3 * slice..3 * slice + 3);
        });
        commands.sample(&self.buffers[1 - before]);
    }
}

/// Work between two slices.
pub(crate) enum BetweenSlices<'a> {
    /// No work.
    Nothing,
    /// Draws the light behind the next slice.
    Light(&'a Light<'a>),
    /// Masks opaque pixels after a number of slices.
    Marks {
        /// Masking pipeline.
        pipeline: &'a Pipeline,
        /// Its inputs: the target.
        set: BindSet,
        /// The mask.
        image: &'a Image,
        /// Number of slices between two maskings.
        every: u32,
    },
}

/// Clears the target and blends the slices into areas of it, as for [`march`], each within its tiles. With several
/// samples per pixel the areas must not touch, and tiles are off: lavapipe (Mesa 22) draws into the row beyond its
/// scissor, so that slices would be blended twice along a border.
///
/// With a light, each slice follows the light behind it and reads the set of the buffer that holds the light before it.
/// With a mask, a pixel ends with the batch that makes it opaque.
///
/// # Errors
/// Those of a submission; [`RenderError::Stopped`].
#[expect(clippy::too_many_arguments, reason = "what is drawn, with what, where")]
pub(crate) fn draw(
    gpu: &Gpu,
    pipeline: &Pipeline,
    sets: [&BindSet; 2],
    vertices: &Buffer,
    stack: &Stack,
    (areas, tiles): (&[Area], &Tiles),
    target: Target<'_>,
    between: &BetweenSlices<'_>,
    control: &mut SubmissionControl<'_>,
) -> Result<PassTiming, RenderError> {
    let into = Target { resolved: None, ..target };
    let first_light_ms = match between {
        BetweenSlices::Light(light) if stack.slices > 0 => light.begin(gpu)?,
        _ => 0.0,
    };
    let mut drawn = if stack.slices > 0 && control.budget.begin() {
        PassTiming::begin(gpu, pipeline, sets[0], Some(vertices), into)?
    } else {
        PassTiming { fragments: Some(0), ..Default::default() }
    };
    drawn.first_use_ms += first_light_ms;
    let mut load = Load::Clear([0.0; 4]);
    let mut next = 0;
    let pixels = (tiles.pixels(0..stack.slices) as f64 / f64::from(stack.slices)).max(1.0);
    while next < stack.slices {
        control.check(drawn.gpu_ms, next as f32 / stack.slices as f32)?;
        let batch = (control.budget.samples() / pixels).max(1.0) as u32;
        let range: Range<u32> = next..next.saturating_add(batch).min(stack.slices);
        let mut blend = |commands: &mut Commands<'_>, slices: Range<u32>| {
            let set = sets[slices.start as usize % 2];
            commands.render(into, load, |draw| {
                for (run, areas) in tiles.runs(slices) {
                    for area in areas {
                        draw.within(area);
                        let span = run.start * stack.per_slice..run.end * stack.per_slice;
                        draw.triangles(pipeline, set, Some(vertices), span);
                    }
                }
            });
            load = Load::Keep;
        };
        let cost = gpu.submit("slices", |commands| match between {
            BetweenSlices::Nothing => blend(commands, range.clone()),
            BetweenSlices::Light(light) => {
                for slice in range.clone() {
                    light.pass(commands, slice);
                    blend(commands, slice..slice + 1);
                }
            }
            BetweenSlices::Marks { pipeline, set, image, every } => {
                let mut from = range.start;
                while from < range.end {
                    let end = ((from / every + 1) * every).min(range.end);
                    blend(commands, from..end);
                    if end.is_multiple_of(*every) && end < stack.slices {
                        commands.mark(target.color, image, |draw| {
                            for area in areas {
                                draw.within(area);
                                draw.triangles(pipeline, set, None, 0..3);
                            }
                        });
                    }
                    from = end;
                }
            }
        })?;
        drawn.add(&cost);
        control.budget.took(f64::from(range.end - range.start) * pixels, cost.gpu_ms);
        next = range.end;
    }
    if target.resolved.is_some() || stack.slices == 0 {
        gpu.submit("resolve", |commands| commands.render(target, load, |_| ()))?;
    }
    Ok(drawn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::camera::Extent;

    const EXTENT: Extent = Extent { distance: 5.0, radius: 2.0, near: 0.1 };

    #[test]
    fn m01_slices_are_the_middles_of_equal_parts_of_the_sphere() {
        let stack = stack(&SlicePlanes::new(EXTENT, 4), EXTENT.radius, Proxy::Quads, Order::FrontToBack, |_| [1.0; 4]);
        let depths: Vec<f32> = stack.vertices.chunks(60).map(|slice| -slice[2]).collect();
        assert_eq!(depths, [3.5, 4.5, 5.5, 6.5]);
        assert_eq!(SlicePlanes::new(EXTENT, 4).step, 1.0);
    }

    #[test]
    fn back_to_front_is_the_same_stack_reversed() {
        let [front, back] = [Order::FrontToBack, Order::BackToFront]
            .map(|order| stack(&SlicePlanes::new(EXTENT, 5), 2.0, Proxy::Polygons, order, |_| [1.0; 4]));
        let floats = 12 * 6;
        let reversed: Vec<f32> = front.vertices.chunks(floats).rev().flatten().copied().collect();
        assert_eq!(back.vertices, reversed);
    }

    #[test]
    fn rows_are_taken_off_the_areas_each_once_and_in_order() {
        let area = |rows: Range<u32>| Area { columns: 2..12, rows };
        let mut areas = VecDeque::from([area(0..4), area(8..14), area(16..18), area(20..22)]);
        assert_eq!(take(&mut areas, 60), [area(0..4), area(8..10)]);
        assert_eq!(take(&mut areas, 3), [area(10..12)], "at least a row of quads");
        assert_eq!(take(&mut areas, 23), [area(12..14)], "no row that is mostly too much");
        assert_eq!(take(&mut areas, 99), [area(16..18), area(20..22)]);
        assert!(areas.is_empty());
    }

    #[test]
    fn slices_behind_the_eye_are_left_out() {
        let inside = Extent { distance: 0.5, ..EXTENT };
        let stack = stack(&SlicePlanes::new(inside, 8), 2.0, Proxy::Polygons, Order::FrontToBack, |_| [1.0; 4]);
        assert!(stack.vertices.chunks(6).all(|vertex| vertex[1] <= -inside.near));
        assert_eq!(stack.slices, 5);
    }
}
