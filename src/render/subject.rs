//! The loaded object of a scene: distance field, placement and size.

use crate::field::{self, ClosestPoints, DistanceField, Progress};
use crate::render::error::RenderError;
use crate::render::variant::Variant;
use crate::scene::{Axis, GLSL, Object, Parameters, Scene};
use crate::shader::Library;
use crate::shape::{self, Opened, Shape, ShapeError};
use glam::{DVec3, Mat3, Mat4, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::Arc;

/// The loaded object of a scene, for any effect.
///
/// Clones share its field. Object space is centered on the object, and the longest side of its bounding box spans [-1,
/// 1] there.
#[derive(Clone, Debug, Default)]
pub struct Subject {
    /// Input as the scene names it.
    pub input: String,
    /// Distance field; `None` for a formula.
    pub field: Option<Arc<DistanceField>>,
    /// Closest points of the surface, on the grid of the field; `None` if no scene reads them.
    pub closest: Option<Arc<ClosestPoints>>,
    /// World position of the origin of object space.
    pub center: Vec3,
    /// Offset subtracted from the coordinates of its file, see [`shape::Mesh::offset`]; in the axes of the file.
    pub offset: DVec3,
    /// Object units in one world unit.
    pub scale: f32,
    /// Half the size of the bounding box, object units.
    pub half_size: Vec3,
    /// Radius of the bounding sphere around the origin, object units.
    pub radius: f32,
    /// Report on the computation of the field.
    pub report: Option<field::FieldReport>,
    /// Iso-value chosen for a scan without a given one.
    pub proposed_iso: Option<f32>,
    /// Files read besides the named one: the data of a header, the slices of a series.
    pub others: Vec<PathBuf>,
    /// The additional objects of the scene, each in its own space.
    pub parts: BTreeMap<String, Subject>,
}

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
    /// Extent of its field beyond the object, object units: see [`field_margin`].
    pub reach: f32,
    /// Whether closest points are read.
    pub closest: bool,
    /// Whether it keeps the position of its file relative to the main object.
    pub aligned: bool,
}

impl SubjectRequest {
    /// Requests for the main object of a scene, then the additional ones in the order of their names; `variant` is the
    /// scene's.
    pub fn all(scene: &Scene, variant: &Variant) -> Vec<SubjectRequest> {
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
                closest: variant.part_reads_closest(name),
                aligned,
            }
        });
        [own].into_iter().chain(parts).collect()
    }
}

/// Request and placement of a field: equal recipes and shapes have equal subjects.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Recipe {
    input: String,
    pub(crate) request: field::Request,
    up: Axis,
    closest: bool,
    aligned: bool,
    /// Iso-value chosen for a scan without a given one.
    proposed_iso: Option<f32>,
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

impl Subject {
    /// Loads the object of a scene and computes its distance field or finds it in the cache.
    ///
    /// # Errors
    /// The input cannot be read, or has no surface.
    pub fn load(scene: &Scene, library: &Library, progress: Progress<'_>) -> Result<Subject, RenderError> {
        let own = |wanted: &SubjectRequest, progress: Progress<'_>| Subject::of(wanted, None, progress);
        Subject::all(scene, library, &own, progress)
    }

    /// Computes the field of an in-memory shape as the main object; additional objects are loaded as the scene names
    /// them. Sets the input of the object to [`MEMORY`](shape::MEMORY) and a hash of its contents, which identifies it
    /// in the picture's metadata.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn from_shape(
        scene: &mut Scene,
        library: &Library,
        shape: Shape,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        scene.object.input = format!("{}{}", shape::MEMORY, field::Key::of_contents(&shape));
        let opened = Opened { shape, notes: Vec::new(), others: Vec::new(), grids: Vec::new() };
        let shape = settled(opened, &scene.object).warned(&scene.object.input);
        let own = |wanted: &SubjectRequest, progress: Progress<'_>| {
            Subject::made(&shape, Recipe::of(&shape, wanted, 1.0), None, Vec::new(), progress)
        };
        Subject::all(scene, library, &own, progress)
    }

    /// Computes the field of a triangle mesh; see [`Mesh::new`](shape::Mesh::new).
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn from_mesh(scene: &mut Scene, library: &Library, mesh: shape::Mesh) -> Result<Subject, RenderError> {
        Subject::from_shape(scene, library, Shape::Mesh(mesh), &|_| ())
    }

    /// Computes the field of a volume; see [`Volume::new`](shape::Volume::new). `object.iso` is the iso-value of
    /// scalars.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn from_volume(scene: &mut Scene, library: &Library, volume: shape::Volume) -> Result<Subject, RenderError> {
        Subject::from_shape(scene, library, Shape::Volume(volume), &|_| ())
    }

    /// Wraps a distance field, whose samples are kept.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn from_field(scene: &mut Scene, library: &Library, field: DistanceField) -> Result<Subject, RenderError> {
        Subject::from_volume(scene, library, field.into_volume())
    }

    /// Samples an implicit function of world space, negative inside and 0 on the surface; it need not be a distance.
    /// Samples lie on a cubic grid in a box, with `object.resolution` along its longest side; finer detail is lost.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn from_fn(
        scene: &mut Scene,
        library: &Library,
        within: shape::Bounds,
        function: impl Fn(Vec3) -> f32 + Sync,
    ) -> Result<Subject, RenderError> {
        let step = within.size().max_element() / (scene.object.resolution.max(2) - 1) as f32;
        let size = (within.size() / step).ceil().as_uvec3() + 1;
        let layer = |z: u32| {
            let row = move |y: u32| (0..size.x).map(move |x| Vec3::new(x as f32, y as f32, z as f32));
            (0..size.y).flat_map(row).map(|at| function(within.min + step * at)).collect::<Vec<f32>>()
        };
        let values = (0..size.z).into_par_iter().flat_map_iter(layer).collect();
        let (steps, content) = (Mat3::from_diagonal(Vec3::splat(step)), shape::Content::LevelSet);
        Subject::from_volume(scene, library, shape::Volume::new(size.to_array(), within.min, steps, values, content)?)
    }

    /// Loads the main object by `own`, then the additional ones.
    fn all(
        scene: &Scene,
        library: &Library,
        own: &dyn Fn(&SubjectRequest, Progress<'_>) -> Result<Subject, RenderError>,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        let objects = SubjectRequest::all(scene, &Variant::of(scene, library)?);
        let count = objects.len() as f32;
        let part = |before: u8| move |done: f32| progress((f32::from(before) + done) / count);
        let mut subject = own(&objects[0], &part(0))?;
        for ((name, wanted), before) in scene.parts.keys().zip(&objects[1..]).zip(1..) {
            let loaded = Subject::of(wanted, Some(&subject), &part(before))?;
            subject.parts.insert(name.clone(), loaded);
        }
        Ok(subject)
    }

    /// Loads an object with a field that extends by `margin` (object units), so that several scenes may share it; with
    /// closest points if one of them reads them.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn load_with_margin(
        object: &Object,
        margin: f32,
        closest: bool,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        let wanted = SubjectRequest { object: object.clone(), reach: field_margin(margin), closest, aligned: false };
        Subject::of(&wanted, None, progress)
    }

    /// Loads an object; `own` is the main object, which defines the space of an aligned one.
    fn of(wanted: &SubjectRequest, own: Option<&Subject>, progress: Progress<'_>) -> Result<Subject, RenderError> {
        let SubjectRequest { object, aligned, .. } = wanted;
        if object.is_formula() {
            return Ok(formula(&object.input));
        }
        let own = own.filter(|_| *aligned);
        let mut opened = opened(object)?;
        let others = std::mem::take(&mut opened.others);
        let shape = opened.warned(&object.input);
        let recipe = Recipe::of(&shape, wanted, own.map_or(1.0, |own| own.scale));
        Subject::made(&shape, recipe, own, others, progress)
    }

    /// Computes the field of a recipe.
    fn made(
        shape: &Shape,
        recipe: Recipe,
        own: Option<&Subject>,
        others: Vec<PathBuf>,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        let Recipe { input, request, up, closest, proposed_iso, .. } = recipe;
        let (field, points, report) = if closest {
            let (field, points, report) = field::load_or_compute_closest(shape, &request, progress)?;
            (field, Some(points), report)
        } else {
            let (field, report) = field::load_or_compute(shape, &request, progress)?;
            (field, None, report)
        };
        let field = field.turned(up.turn());
        let points = points.map(|points| points.turned(up.turn()));
        let (low, high) = inside_bounds(&field);
        let offset = if let Shape::Mesh(mesh) = shape { mesh.offset } else { DVec3::ZERO };
        let (center, scale) = match own {
            None => (0.5 * (low + high), 2.0 / (high - low).max_element()),
            Some(own) => (own.center + up.turned(own.offset - offset).as_vec3(), own.scale),
        };
        // Squares of tiny lengths underflow f32; scaling by a power of two is exact.
        let handy = scale.log2().floor().exp2();
        let radius =
            inside_points(&field).map(|p| ((p - center) * handy).length()).fold(0.0, f32::max) * (scale / handy);
        let half_size = scale * (high - center).max(center - low);
        let (field, report, parts) = (Some(Arc::new(field)), Some(report), BTreeMap::new());
        let closest = points.map(Arc::new);
        Ok(Subject {
            input,
            field,
            closest,
            center,
            offset,
            scale,
            half_size,
            radius,
            report,
            proposed_iso,
            others,
            parts,
        })
    }

    /// From object space to the world of its shape.
    pub fn world(&self) -> Mat4 {
        Mat4::from_translation(self.center) * Mat4::from_scale(Vec3::splat(1.0 / self.scale))
    }

    /// Additional files of all objects.
    pub fn all_others(&self) -> impl Iterator<Item = &PathBuf> {
        self.others.iter().chain(self.parts.values().flat_map(|part| &part.others))
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
fn settled(mut opened: Opened, object: &Object) -> Opened {
    if let Shape::Volume(volume) = &mut opened.shape {
        if object.distance {
            volume.content = shape::Content::SignedDistance;
        }
        if volume.content == shape::Content::SignedDistance && !volume.is_aligned() {
            let note = "its grid stands askew; its surface is kept, distances are computed anew";
            opened.notes.push(note.into());
            volume.content = shape::Content::LevelSet;
        }
        if volume.content == shape::Content::SignedDistance
            && let Some(slope) = volume.slope_at_zero().filter(|slope| !DISTANCE.contains(slope))
        {
            opened.notes.push(format!(
                "its values are no distances, they change by {slope:.3} per world unit; its surface is kept, distances are computed anew"
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
pub fn field_margin(margin: f32) -> f32 {
    (margin.max(0.0) / MARGIN_STEP + 1e-3).ceil().max(1.0) * MARGIN_STEP
}

/// A built-in formula in `glsl/object`.
fn formula(name: &str) -> Subject {
    let (half_size, radius) = match name {
        _ if name == "cube" || name.starts_with(GLSL) => (Vec3::ONE, 3f32.sqrt()),
        "torus" => (Vec3::new(1.0, 0.3, 1.0), 1.0),
        _ => (Vec3::ONE, 1.0),
    };
    Subject { input: name.into(), scale: 1.0, half_size, radius, ..Subject::default() }
}

/// World positions of the samples inside, or of the nearest to the surface if none are.
fn inside_points(field: &DistanceField) -> impl Iterator<Item = Vec3> + '_ {
    let threshold = field.range().0.max(0.0);
    let [nx, ny, _] = field.grid.size;
    let inside = field.values.iter().enumerate().filter(move |(_, distance)| **distance <= threshold);
    inside.map(move |(index, _)| {
        let index = index as u32;
        field.grid.position(index % nx, index / nx % ny, index / (nx * ny))
    })
}

/// Bounding box of the inside, grown by half a voxel.
fn inside_bounds(field: &DistanceField) -> (Vec3, Vec3) {
    let (low, high) =
        inside_points(field).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    (low - 0.5 * field.grid.spacing, high + 0.5 * field.grid.spacing)
}
