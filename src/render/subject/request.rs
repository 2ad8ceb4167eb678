//! Requests for objects and their fields.

use crate::field;
use crate::render::variant::Variant;
use crate::scene::{Axis, Object, Parameters};
use crate::shape::{self, Opened, Shape, ShapeError};
use std::ops::RangeInclusive;

/// Granularity of the field's margin around the object, object units. Lower: the field is recomputed for every length
/// of hair. Higher: wasted voxels.
const MARGIN_STEP: f32 = 0.25;

/// Accepted slopes of a signed distance field at its surface, per world unit; blurred fields have lower ones.
const DISTANCE: RangeInclusive<f32> = 0.8..=1.25;

/// Parameters of loading an object, known before any file is read.
#[derive(Clone, Debug, PartialEq)]
pub struct SubjectRequest {
    /// The object; an aligned one has the up axis of the main object.
    pub object: Object,
    /// Extent of its field beyond the object, object units: see `field_margin`.
    pub reach: f32,
    /// Whether closest points are read.
    pub closest: bool,
    /// Whether it keeps the position of its file relative to the main object.
    pub aligned: bool,
}

impl SubjectRequest {
    /// Requests for the main object of a scene, then the additional ones in the order of their names.
    pub fn all(variant: &Variant) -> Vec<SubjectRequest> {
        let scene = &variant.scene;
        let reach =
            |parameters: &Parameters, object: &Object| field_margin(parameters.outer_iso().unwrap_or(object.outer_iso));
        let own = SubjectRequest {
            object: scene.object.clone(),
            reach: reach(&variant.parameters, &scene.object),
            closest: variant.reads_closest(),
            aligned: false,
        };
        let parts = scene.parts.iter().map(|(name, part)| {
            let aligned = part.transform.aligned;
            let up = if aligned { scene.object.up } else { part.object.up };
            SubjectRequest {
                object: Object { up, ..part.object.clone() },
                reach: reach(&variant.parts[name], &part.object),
                closest: variant.module(&format!("{name}.project")) == Some("closest"),
                aligned,
            }
        });
        [own].into_iter().chain(parts).collect()
    }
}

/// Request and placement of a field: equal recipes and shapes have equal subjects.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Recipe {
    pub(super) input: String,
    pub(crate) request: field::Request,
    pub(super) up: Axis,
    pub(super) closest: bool,
    aligned: bool,
    /// Iso-value chosen for a scan without a given one.
    pub(super) proposed_iso: Option<f32>,
}

impl Recipe {
    /// Recipe of an object that is not a formula; `scale` is the main object's.
    pub(crate) fn of(shape: &Shape, wanted: &SubjectRequest, scale: f32) -> Recipe {
        let SubjectRequest { object, reach, closest, aligned } = wanted;
        let mut request = reaching(shape, object, *reach);
        if *aligned {
            (request.margin, request.band) = (reach / scale, reach / scale);
        }
        let is_brought = object.iso.is_none() && is_scan(shape, &object.input);
        if let Some(iso) = proposed(shape, &object.input, true).filter(|_| is_brought && *aligned) {
            request.iso = iso;
        }
        let proposed_iso = is_brought.then_some(request.iso);
        let (input, up) = (object.input.clone(), object.up);
        Recipe { input, request, up, closest: *closest, aligned: *aligned, proposed_iso }
    }
}

/// Opens the shape of an object.
///
/// # Errors
/// The input cannot be read.
pub fn open(object: &Object) -> Result<Shape, ShapeError> {
    Ok(opened(object)?.warned(&object.input))
}

/// Opens the shape of an object with notes on its file.
pub(crate) fn opened(object: &Object) -> Result<Opened, ShapeError> {
    Ok(settled(Opened::with_grid(&object.input, object.grid.as_deref())?, object))
}

/// Settles the content type of a volume, from the scene and from the values.
pub(super) fn settled(mut opened: Opened, object: &Object) -> Opened {
    if let Shape::Volume(volume) = &mut opened.shape {
        if object.distance {
            volume.content = shape::Content::SignedDistance;
        }
        if volume.content == shape::Content::SignedDistance && !volume.is_aligned() {
            let note = "its grid is skewed; its surface is used, distances are recomputed";
            opened.notes.push(note.into());
            volume.content = shape::Content::LevelSet;
        }
        if volume.content == shape::Content::SignedDistance
            && let Some(slope) = volume.slope_at_zero().filter(|slope| !DISTANCE.contains(slope))
        {
            opened.notes.push(format!(
                "its values change by {slope:.3} per world unit, unlike distances; its surface is used, distances are recomputed"
            ));
            volume.content = shape::Content::LevelSet;
        }
    }
    opened
}

/// Whether the shape is a scalar volume from a file.
fn is_scan(shape: &Shape, input: &str) -> bool {
    let is_scalar = matches!(shape, Shape::Volume(volume) if volume.content == shape::Content::Scalar);
    is_scalar && !shape::BUILT_IN.contains(&input)
}

/// Iso-value for a scan without a given one: the lowest between two materials, most often the outer surface; `within`
/// another object, the highest.
fn proposed(shape: &Shape, input: &str, within: bool) -> Option<f32> {
    let Shape::Volume(volume) = shape else { return None };
    if !is_scan(shape, input) {
        return None;
    }
    let (low, high) = volume.range();
    let isos: Vec<f32> = volume.iso_values().into_iter().filter(|iso| low < *iso && *iso <= high).collect();
    if within { isos.last().copied() } else { isos.first().copied() }
}

/// Request for a shape's field, in world units. Without an iso-value, a volume takes the proposed one, else the middle
/// of its range.
pub fn request(shape: &Shape, object: &Object, margin: f32) -> field::Request {
    reaching(shape, object, field_margin(margin))
}

/// Request for a field that extends by `reach` beyond the object, object units.
fn reaching(shape: &Shape, object: &Object, reach: f32) -> field::Request {
    let bounds = shape.bounds();
    let half = 0.5 * (bounds.max - bounds.min).max_element();
    let middle = || match shape {
        Shape::Volume(volume) if volume.content == shape::Content::Scalar => {
            let (low, high) = volume.range();
            0.5 * low + 0.5 * high
        }
        _ => 0.0,
    };
    let own = (object.input == "head").then_some(shape::head::SKIN);
    let iso = object.iso.or(own).or_else(|| proposed(shape, &object.input, false)).unwrap_or_else(middle);
    let margin = reach * half;
    field::Request { resolution: object.resolution, margin, band: margin, iso, shell: object.shell * half }
}

/// Actual extent of a field beyond its object, object units.
pub(crate) fn field_margin(margin: f32) -> f32 {
    (margin.max(0.0) / MARGIN_STEP + 1e-3).ceil().max(1.0) * MARGIN_STEP
}
