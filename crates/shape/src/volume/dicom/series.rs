//! Grid of the slices of a DICOM series.
//!
//! Invariant: each slice is within 1/50 gap of its place in the grid, or within a tenth of a millimeter with a note; missing
//! and duplicate slices are refused. Source: NEMA PS3.3, C.7.6.2.1.1.

use super::image::{Frame, Image};
use crate::error::{Location, ShapeError, first_few, quoted};
use crate::shape::Content;
use crate::shape::axes::lengths;
use crate::source::Source;
use crate::volume::placement::{self, Placement};
use crate::volume::space::Space;
use glam::{DMat3, DVec3};
use std::path::PathBuf;

/// Tolerance of a slice position in gaps: the rounding of scanners.
const OFF: f64 = 0.02;
/// Tolerance of directions, their length and their right angle: the rounding to 16 characters, and more.
const TURN: f64 = 1e-3;
/// Tolerance where positions are rounded to a tenth of a millimeter, in mm: half of a tenth for each of two slices.
const ROUNDED: f64 = 0.101;
/// Least number of distances for each that a missing slice explains.
const MISSING: usize = 4;
/// Largest distance of slices by the smallest one; beyond it a position is wrong.
const MOST_UNLIKE: f64 = 5.0;
/// Most kinds of images in a series; with more, none is left out.
const MOST_GROUPS: usize = 16;

/// File of a series.
pub(super) struct Member {
    /// Path; empty for a file in memory.
    pub path: PathBuf,
    pub image: Image,
}

/// Grid of a series, and the slice index of each frame.
pub(super) struct Layout {
    pub placement: Placement,
    /// Slice index by file and frame.
    pub slices: Vec<Vec<usize>>,
    /// The grid between the slices, if their distances differ.
    pub even: Option<Even>,
}

/// Grid of even distances between slices of uneven ones.
pub(super) struct Even {
    pub placement: Placement,
    /// Place of each of its slices among those of the series, from 0.
    pub places: Vec<f64>,
}

/// Frame with its position.
struct Slice {
    file: usize,
    frame: usize,
    position: DVec3,
    /// Position along the normal of the slices, in mm.
    height: f64,
}

impl Member {
    /// Quoted file name.
    pub fn name(&self) -> String {
        quoted(self.path.file_name().unwrap_or_default().to_string_lossy().as_bytes())
    }

    /// Whether size, orientation and pixel spacing equal those of another image.
    fn is_like(&self, other: &Member) -> bool {
        let of = |member: &Member| {
            let frame = member.image.frames.first()?;
            Some((Plane::of(frame).ok()?, (member.image.columns, member.image.rows, frame.position.is_some())))
        };
        match (of(self), of(other)) {
            (Some((plane, sides)), Some((to, other))) => {
                plane.is_parallel_to(&to) && plane.has_spacing_of(&to) && sides == other
            }
            (plane, to) => plane.is_none() && to.is_none(),
        }
    }

    /// Name of a frame for a message.
    fn shown(&self, frame: usize) -> String {
        match (self.image.frames.len() > 1, self.path.file_name()) {
            (true, None) => format!("frame {}", frame + 1),
            (true, Some(_)) => format!("frame {} of {}", frame + 1, self.name()),
            (false, _) => self.name(),
        }
    }
}

/// Grid of the frames of `members`.
pub(super) fn layout(source: &Source, members: &[Member]) -> Result<Layout, ShapeError> {
    let file = &*source.file;
    let wrong = |expected, found| {
        let place = if members.len() > 1 { Location::Folder } else { Location::Header };
        ShapeError::Malformed { file: file.into(), place, expected, found }
    };
    let frames = members.iter().enumerate().flat_map(|(file, member)| {
        member.image.frames.iter().enumerate().map(move |(frame, about)| (file, member, frame, about))
    });
    let (mut first, mut slices) = (None, Vec::new());
    for (file, member, frame, about) in frames {
        let of_this = |expected, found: String| wrong(expected, format!("{found} in {}", member.shown(frame)));
        let own = Plane::of(about).map_err(|(expected, found)| of_this(expected, found))?;
        let (columns, rows) = (member.image.columns, member.image.rows);
        let (plane, sides) = first.get_or_insert((own, (columns, rows)));
        if (columns, rows) != *sides {
            let found = format!("{columns} x {rows} and {} x {}", sides.0, sides.1);
            return Err(of_this("as many rows and columns in all slices", found));
        }
        if !own.is_parallel_to(plane) {
            let found = format!("{} {} and {} {}", vector(own.x), vector(own.y), vector(plane.x), vector(plane.y));
            return Err(of_this("the same orientation of all slices", found));
        }
        if !own.has_spacing_of(plane) {
            let found = format!("{:?} and {:?} mm", own.spacing, plane.spacing);
            return Err(of_this("the same PixelSpacing in all slices", found));
        }
        let position = about.position.ok_or_else(|| of_this("an ImagePositionPatient", "none".into()))?;
        let position = DVec3::from(position);
        slices.push(Slice { file, frame, position, height: position.dot(plane.x.cross(plane.y)) });
    }
    let Some((Plane { x, y, spacing }, (columns, rows))) = first else {
        return Err(wrong("slices", "none".into()));
    };
    slices.sort_by(|a, b| a.height.total_cmp(&b.height));
    let name = |slice: &Slice| members[slice.file].shown(slice.frame);
    let (first, step, places) = line(source, &slices, &name).map_err(|(expected, found)| wrong(expected, found))?;
    let size = [columns.into(), rows.into(), slices.len() as u64];
    let size = placement::checked(file, size)?;
    let mut order: Vec<Vec<usize>> = members.iter().map(|member| vec![0; member.image.frames.len()]).collect();
    for (index, slice) in slices.iter().enumerate() {
        order[slice.file][slice.frame] = index;
    }
    // The second spacing is that between columns, along x.
    let steps = DMat3::from_cols(x * spacing[1], y * spacing[0], step);
    if !placement::are_lengths(lengths(&steps)) {
        return Err(wrong(placement::STEPS, vector(lengths(&steps))));
    }
    let placement = |size| {
        let placement = Placement::new(Space::LPS, size, (first, steps), Content::Scalar);
        placement.check(file).map(|()| placement)
    };
    let even = places.map(|places| {
        let size = placement::checked(file, [columns.into(), rows.into(), places.len() as u64])?;
        Ok::<_, ShapeError>(Even { placement: placement(size)?, places })
    });
    Ok(Layout { placement: placement(size)?, slices: order, even: even.transpose()? })
}

/// Expected and found.
type Wrong = (&'static str, String);

/// Plane of a frame: unit directions along rows and columns, and the distances between rows and columns.
#[derive(Clone, Copy)]
struct Plane {
    x: DVec3,
    y: DVec3,
    spacing: [f64; 2],
}

impl Plane {
    fn of(frame: &Frame) -> Result<Plane, Wrong> {
        let [a, b, c, d, e, f] = frame.orientation.ok_or_else(|| ("an ImageOrientationPatient", "none".to_string()))?;
        let (x, y) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
        let off = (x.length() - 1.0).abs().max((y.length() - 1.0).abs()).max(x.dot(y).abs());
        if off.is_nan() || off > TURN {
            let expected = "an ImageOrientationPatient of two directions at right angles";
            return Err((expected, format!("{} {}", vector(x), vector(y))));
        }
        let spacing = frame.spacing.ok_or_else(|| ("a PixelSpacing", "none".to_string()))?;
        if spacing.iter().any(|spacing| *spacing <= 0.0) {
            return Err(("a PixelSpacing above 0", format!("{spacing:?}")));
        }
        Ok(Plane { x: x.normalize(), y: y.normalize(), spacing })
    }

    fn is_parallel_to(&self, other: &Plane) -> bool {
        self.x.distance(other.x).max(self.y.distance(other.y)) <= TURN
    }

    fn has_spacing_of(&self, other: &Plane) -> bool {
        self.spacing.iter().zip(other.spacing).all(|(own, other)| (own - other).abs() <= TURN * other)
    }
}

/// Position of the first slice and the step to the next; with different distances, the places of evenly spaced slices too.
type Line = (DVec3, DVec3, Option<Vec<f64>>);

fn line(source: &Source, slices: &[Slice], name: &dyn Fn(&Slice) -> String) -> Result<Line, Wrong> {
    let (Some(first), Some(last), true) = (slices.first(), slices.last(), slices.len() > 1) else {
        return Err(("at least 2 slices of a series in a folder", slices.len().to_string()));
    };
    let gaps = slices.windows(2).map(|pair| pair[1].height - pair[0].height);
    let mut gaps: Vec<f64> = gaps.filter(|gap| *gap > 0.0).collect();
    gaps.sort_by(f64::total_cmp);
    let usual = gaps.get(gaps.len().saturating_sub(1) / 2).copied().unwrap_or_default();
    let is_uneven = is_variable(&gaps, usual) && gaps[gaps.len() - 1] <= MOST_UNLIKE * gaps[0];
    for pair in slices.windows(2) {
        let gap = pair[1].height - pair[0].height;
        let between = || format!("{} and {}", name(&pair[0]), name(&pair[1]));
        if gap <= OFF * usual {
            let found = format!("{} both at {} mm", between(), shown_mm(pair[0].height));
            return Err(("one slice at each place", found));
        }
        if !is_uneven && (gap - usual).abs() > slack(usual) {
            let found = format!("{} mm between {}, others are {} mm apart", shown_mm(gap), between(), shown_mm(usual));
            return Err(("slices at even distances, none missing", found));
        }
    }
    if is_uneven {
        return interpolated(source, slices, [gaps[0], gaps[gaps.len() - 1]], name);
    }
    // Largest distance of a slice from a line, and its index.
    let farthest = |(start, step): (DVec3, DVec3)| {
        let off = |(index, slice): (usize, &Slice)| slice.position.distance(start + step * index as f64);
        let offs = slices.iter().enumerate().map(|(index, slice)| (off((index, slice)), index));
        offs.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    };
    let straight = (first.position, (last.position - first.position) / (slices.len() - 1) as f64);
    let (off, index) = farthest(straight);
    if off <= OFF * usual {
        return Ok((straight.0, straight.1, None));
    }
    let fitted = fitted(slices);
    if farthest(fitted).0 > slack(usual) {
        let found = format!("{} {} mm off it", name(&slices[index]), shown_mm(off));
        return Err(("slices on a straight line at even distances", found));
    }
    let text = "the positions of its slices are rounded, by up to";
    source.note(format!(
        "{text} {} mm: even distances of {} mm are used",
        shown_mm(farthest(fitted).0),
        shown_mm(fitted.1.length())
    ));
    Ok((fitted.0, fitted.1, None))
}

/// Whether rising distances differ by more than a few missing slices explain, which leave gaps of whole multiples.
fn is_variable(gaps: &[f64], usual: f64) -> bool {
    let odd: Vec<f64> = gaps.iter().copied().filter(|gap| (gap - usual).abs() > slack(usual)).collect();
    let is_multiple = |gap: &f64| {
        let times = (gap / usual).round();
        times >= 2.0 && (gap - times * usual).abs() <= times * slack(usual)
    };
    let are_few = odd.len() == 1 || odd.len() * MISSING <= gaps.len();
    !(odd.is_empty() || odd.iter().all(is_multiple) && are_few)
}

/// Places of evenly spaced slices, as far apart as the nearest ones, on the straight line of `slices`.
fn interpolated(
    source: &Source,
    slices: &[Slice],
    [nearest, farthest]: [f64; 2],
    name: &dyn Fn(&Slice) -> String,
) -> Result<Line, Wrong> {
    let (first, last) = (&slices[0], &slices[slices.len() - 1]);
    let height = last.height - first.height;
    let count = (height / nearest).round().max(1.0);
    let along = (last.position - first.position) / height;
    let off = |slice: &Slice| slice.position.distance(first.position + along * (slice.height - first.height));
    if let Some(slice) = slices.iter().find(|slice| off(slice) > slack(nearest)) {
        let found = format!("{} {} mm off it", name(slice), shown_mm(off(slice)));
        return Err(("slices on a straight line", found));
    }
    let step = height / count;
    let mut below = 0;
    let places = (0..=count as usize).map(|index| {
        let at = first.height + index as f64 * step;
        while below + 2 < slices.len() && slices[below + 1].height <= at {
            below += 1;
        }
        let [low, high] = [&slices[below], &slices[below + 1]].map(|slice| slice.height);
        (below as f64 + (at - low) / (high - low)).clamp(0.0, (slices.len() - 1) as f64)
    });
    let places = places.collect();
    source.note(format!(
        "its slices are {} to {} mm apart: it is interpolated at even distances of {} mm",
        shown_mm(nearest),
        shown_mm(farthest),
        shown_mm(step)
    ));
    Ok((first.position, along * step, Some(places)))
}

/// Tolerance of a gap, by the usual gap.
fn slack(usual: f64) -> f64 {
    (OFF * usual).max(ROUNDED.min(0.5 * usual))
}

/// Least-squares line through evenly spaced slices: start and step.
fn fitted(slices: &[Slice]) -> (DVec3, DVec3) {
    let middle = 0.5 * (slices.len() as f64 - 1.0);
    let center = slices.iter().map(|slice| slice.position).sum::<DVec3>() / slices.len() as f64;
    let (mut slope, mut weight) = (DVec3::ZERO, 0.0);
    for (index, slice) in slices.iter().enumerate() {
        let from = index as f64 - middle;
        slope += from * (slice.position - center);
        weight += from * from;
    }
    (center - slope / weight * middle, slope / weight)
}

/// Images of a series without a few of another size, orientation or without a position, as localizers and reports, with a note.
/// All images if fewer than three quarters are alike.
pub(super) fn without_others(source: &Source, members: Vec<Member>) -> Vec<Member> {
    let mut groups: Vec<(usize, Vec<usize>)> = Vec::new();
    for (index, member) in members.iter().enumerate() {
        match groups.iter_mut().find(|(first, _)| member.is_like(&members[*first])) {
            Some((_, own)) => own.push(index),
            None => groups.push((index, vec![index])),
        }
        if groups.len() > MOST_GROUPS {
            return members;
        }
    }
    let largest = groups.into_iter().max_by_key(|(_, own)| own.len()).map(|(_, own)| own).unwrap_or_default();
    if largest.len() == members.len() || largest.len() < 3 || 4 * largest.len() < 3 * members.len() {
        return members;
    }
    let is_own = |index: &usize| largest.binary_search(index).is_ok();
    let others: Vec<String> =
        (0..members.len()).filter(|index| !is_own(index)).map(|index| members[index].name()).collect();
    let named = first_few(&others, ", ");
    let text = "of another size or orientation than the other slices, and left out";
    source.note(format!("{} of its {} pictures ({named}): {text}", others.len(), members.len()));
    let own = members.into_iter().enumerate().filter(|(index, _)| is_own(index));
    own.map(|(_, member)| member).collect()
}

/// Length for a message, to a micrometer.
fn shown_mm(length: f64) -> String {
    format!("{:?}", (length * 1e3).round() / 1e3)
}

fn vector(vector: DVec3) -> String {
    let [x, y, z] = vector.to_array();
    format!("({x:?},{y:?},{z:?})")
}
