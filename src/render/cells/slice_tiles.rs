//! Tiles in which slices or rays meet cells that may hold matter.
//!
//! Invariant: a slice, or a ray, has no matter outside its tiles.

use super::prover::CellGrid;
use super::tiles::{SIDE, Tiles};
use crate::gpu::Area;
use crate::render::camera::FrameContext;
use crate::scene::{Order, Pass};
use glam::{Mat4, Vec2, Vec3};
use std::ops::Range;

/// Groups of slices with common tiles, for each cell along the axis of view.
const GROUPS: u32 = 4;
/// Growth of a projected cell, pixels: sub-frames shift the picture by half a pixel, and positions are rounded.
const MARGIN: f32 = 1.5;
/// Growth of a cell along the axis of view, in steps between planes: jitter shifts samples by up to a half. Samples
/// that look back add one.
const REACH: f32 = 0.75;

/// Tiles in which cells that may hold matter meet the slices of a picture, or its straight rays, within some areas. Rays take
/// samples where the slices are, and all of them are one group.
pub(super) fn tiles(frame: &FrameContext, boxes: &CellGrid, empty: &[bool], within: &[Area]) -> Tiles {
    let (planes, side) = (&frame.planes, boxes.side);
    let alike = match frame.variant.scene.quality.pass {
        Pass::Slices => (planes.count / (GROUPS * side)).max(1),
        Pass::March => planes.count.max(1),
    };
    let [columns, rows] = frame.variant.scene.image.size.map(|side| side.div_ceil(SIDE) as usize);
    let mut marks = vec![vec![false; columns * rows]; planes.count.div_ceil(alike) as usize];
    let seen = Seen::of(frame);
    for index in (0..side.pow(3)).filter(|&index| !empty[index as usize]) {
        let cell = boxes.cell([index % side, index / side % side, index / side / side], side);
        let [x, y, z, _] = cell.map(|range| [range.lo as f32, range.hi as f32]);
        let (depths, across, down) = seen.around([x, y, z]);
        let plane = |depth: f32| (depth - planes.first_depth) / planes.step;
        let behind = REACH + f32::from(u8::from(frame.variant.looks_back));
        let met = within_count(plane(depths.start) - REACH + 1.0..plane(depths.end) + behind, planes.count as usize);
        let drawn = match frame.variant.scene.quality.order {
            Order::FrontToBack => met,
            Order::BackToFront => planes.count as usize - met.end..planes.count as usize - met.start,
        };
        let tiles = |range: Range<f32>, count| within_count(range.start / SIDE as f32..range.end / SIDE as f32, count);
        let (across, down) = (tiles(across, columns), tiles(down, rows));
        if !drawn.is_empty() {
            for marks in &mut marks[drawn.start / alike as usize..=(drawn.end - 1) / alike as usize] {
                down.clone().for_each(|row| marks[row * columns..][across.clone()].fill(true));
            }
        }
    }
    Tiles::of_marks(&marks, columns, alike, within)
}

/// Indices of the unit intervals that a range touches, below `count`.
fn within_count(range: Range<f32>, count: usize) -> Range<usize> {
    // The cast clamps negative numbers to 0.
    let end = (range.end.floor() + 1.0) as usize;
    let end = end.min(count);
    (range.start.floor() as usize).min(end)..end
}

/// Projection from object space to pixels.
struct Seen {
    object_matrix: Mat4,
    projection: Mat4,
    pan: Vec2,
    size: Vec2,
    near: f32,
}

impl Seen {
    fn of(frame: &FrameContext) -> Seen {
        let view = &frame.view;
        Seen {
            object_matrix: view.object_matrix,
            projection: view.projection,
            pan: view.pan.into(),
            size: Vec2::from(frame.variant.scene.image.size.map(|side| side as f32)),
            near: view.extent.near,
        }
    }

    /// Depths, pixel columns and pixel rows of a box; the whole picture if the box reaches the eye.
    fn around(&self, [x, y, z]: [[f32; 2]; 3]) -> (Range<f32>, Range<f32>, Range<f32>) {
        let corner = |bits: usize| Vec3::new(x[bits & 1], y[bits >> 1 & 1], z[bits >> 2]);
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|bits| self.object_matrix.transform_point3(corner(bits)));
        let depths = corners.map(|corner| -corner.z);
        let depths = depths.into_iter().fold(f32::INFINITY, f32::min)..depths.into_iter().fold(0.0, f32::max);
        if depths.start <= self.near {
            return (depths, 0.0..self.size.x, 0.0..self.size.y);
        }
        let places = corners.map(|corner| {
            let clip = self.projection * corner.extend(1.0);
            0.5 * (Vec2::new(clip.x, clip.y) / clip.w + self.pan + 1.0) * self.size
        });
        let low = places.into_iter().fold(self.size, Vec2::min) - MARGIN;
        let high = places.into_iter().fold(Vec2::ZERO, Vec2::max) + MARGIN;
        (depths, low.x..high.x, low.y..high.y)
    }
}
