//! Areas of the picture in which each slice, or all rays, are drawn.
//!
//! Invariant: the areas of a slice do not overlap, so that clipping to them changes no bit of its pixels.

use crate::gpu::Area;
use std::ops::Range;

/// Pixels along a side of a tile. Lower: more draw calls than they save.
pub(super) const SIDE: u32 = 32;

/// Areas of each slice, in drawing order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tiles {
    /// Number of consecutive slices with common areas.
    alike: u32,
    /// Areas of each group of slices.
    areas: Vec<Vec<Area>>,
}

impl Tiles {
    /// Common areas of all slices.
    pub(crate) fn everywhere(areas: &[Area]) -> Tiles {
        Tiles { alike: u32::MAX, areas: vec![areas.to_vec()] }
    }

    /// Areas of the marked tiles for each group of `alike` slices, clipped to some areas; `columns` tiles in a row.
    pub(crate) fn of_marks(marks: &[Vec<bool>], columns: usize, alike: u32, within: &[Area]) -> Tiles {
        Tiles { alike, areas: marks.iter().map(|marks| cut(&joined(marks, columns), within)).collect() }
    }

    /// Runs of slices with common areas.
    pub(crate) fn runs(&self, slices: Range<u32>) -> impl Iterator<Item = (Range<u32>, &[Area])> {
        let numbered = (0u32..).zip(&self.areas);
        numbered.filter_map(move |(number, areas)| {
            let first = number.saturating_mul(self.alike);
            let run = first.max(slices.start)..first.saturating_add(self.alike).min(slices.end);
            (!run.is_empty()).then_some((run, &areas[..]))
        })
    }

    /// Areas in which rays may meet matter.
    pub(crate) fn of_rays(&self) -> &[Area] {
        self.areas.first().map_or(&[], Vec::as_slice)
    }

    /// Pixels drawn by a range of slices.
    pub(crate) fn pixels(&self, slices: Range<u32>) -> u64 {
        let of = |areas: &[Area]| areas.iter().map(Area::pixels).sum::<u64>();
        self.runs(slices).map(|(run, areas)| run.len() as u64 * of(areas)).sum()
    }
}

/// Merges marked tiles into few areas: runs of a row, joined with an equally wide run above.
fn joined(marks: &[bool], columns: usize) -> Vec<Area> {
    let mut areas: Vec<Area> = Vec::new();
    for (row, marks) in (0u32..).zip(marks.chunks(columns)) {
        let rows = row * SIDE..(row + 1) * SIDE;
        let mut column = 0;
        while column < columns {
            let end = (column..columns).find(|&at| !marks[at]).unwrap_or(columns);
            let run = column as u32 * SIDE..end as u32 * SIDE;
            match areas.iter_mut().find(|area| area.columns == run && area.rows.end == rows.start) {
                _ if run.is_empty() => (),
                Some(above) => above.rows.end = rows.end,
                None => areas.push(Area { columns: run, rows: rows.clone() }),
            }
            column = end + 1;
        }
    }
    areas
}

/// Intersections of two sets of areas.
fn cut(areas: &[Area], within: &[Area]) -> Vec<Area> {
    let both = |a: &Range<u32>, b: &Range<u32>| a.start.max(b.start)..a.end.min(b.end);
    let cut = within.iter().flat_map(|own| {
        areas
            .iter()
            .map(move |area| Area { columns: both(&own.columns, &area.columns), rows: both(&own.rows, &area.rows) })
    });
    cut.filter(|area| !area.columns.is_empty() && !area.rows.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marked_tiles_become_few_areas_that_cover_each_once() {
        let marks = [true, true, false, true, true, true, false, false, false, true, true, true];
        let area = |columns: Range<u32>, rows: Range<u32>| Area {
            columns: columns.start * SIDE..columns.end * SIDE,
            rows: rows.start * SIDE..rows.end * SIDE,
        };
        let found = joined(&marks, 4);
        assert_eq!(found, [area(0..2, 0..2), area(3..4, 0..1), area(1..4, 2..3)]);
        let within = [Area { columns: 10..40, rows: 0..1 }, Area { columns: 0..5, rows: 70..80 }];
        assert_eq!(cut(&found, &within), [Area { columns: 10..40, rows: 0..1 }]);
    }

    #[test]
    fn slices_with_the_same_areas_are_drawn_together() {
        let area = |column| Area { columns: column..column + 2, rows: 0..1 };
        let tiles = Tiles { alike: 2, areas: vec![vec![area(0)], vec![], vec![area(2), area(4)]] };
        let runs = |slices| -> Vec<_> { tiles.runs(slices).map(|(run, own)| (run, own.len())).collect() };
        assert_eq!(runs(0..5), [(0..2, 1), (2..4, 0), (4..5, 2)]);
        assert_eq!(runs(1..3), [(1..2, 1), (2..3, 0)]);
        assert_eq!(tiles.pixels(0..5), 8);
        assert_eq!(Tiles::everywhere(&[area(1)]).runs(3..9).collect::<Vec<_>>(), [(3..9, &[area(1)][..])]);
    }
}
