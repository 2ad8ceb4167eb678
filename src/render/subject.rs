//! The object of a scene, ready to be drawn: its field, its place and its size.

use super::RenderError;
use crate::field::{self, ClosestPoints, DistanceField, Progress};
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

/// The object of a scene, ready to be drawn in any effect.
///
/// Clones share its field. Object space is centered on the object, and the longest side of its bounding box spans [-1, 1] there.
#[derive(Clone, Debug, Default)]
pub struct Subject {
    /// What the scene calls it.
    pub input: String,
    /// The distance field; `None` for a formula, which needs none.
    pub field: Option<Arc<DistanceField>>,
    /// The closest points of the surface, on the grid of the field; `None` where no scene reads them.
    pub closest: Option<Arc<ClosestPoints>>,
    /// World position of the origin of object space.
    pub center: Vec3,
    /// What was taken from the coordinates of its file, see [`shape::Mesh::offset`]; by the axes of the file.
    pub offset: DVec3,
    /// Object units in one world unit.
    pub scale: f32,
    /// Half the size of the bounding box, object units.
    pub half_size: Vec3,
    /// Radius of the sphere around the object at the origin, object units.
    pub radius: f32,
    /// How the field was made.
    pub report: Option<field::FieldReport>,
    /// The iso-value of a scan for which none was given.
    pub proposed_iso: Option<f32>,
    /// Files that it was read from besides the one that the scene names: the data of a header, the slices of a series.
    pub others: Vec<PathBuf>,
    /// The additional objects of the scene, each in a space of its own.
    pub parts: BTreeMap<String, Subject>,
}

/// The field covers at least this much around the object, object units; more in steps of it. A finer step would compute
/// the field anew for every length of hair; a coarser one would waste voxels.
const MARGIN_STEP: f32 = 0.25;

/// How much the values of a distance field change per world unit where its surface is; blurred ones by less. What is farther
/// off is no distance.
const DISTANCE: RangeInclusive<f32> = 0.8..=1.25;

/// What a scene needs of an object, before any file is read: all that its subject is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// The object; an aligned one has the axis of the scene's own.
    pub object: Object,
    /// How far its field reaches beyond it, object units: see [`field_margin`].
    pub reach: f32,
    /// Whether its closest points are read.
    pub closest: bool,
    /// Whether it is where its file has it beside the scene's own object.
    pub aligned: bool,
}

impl Wanted {
    /// The objects of a scene: its own, then the additional ones by their names. `variant` is that of the scene.
    pub fn all(scene: &Scene, variant: &Variant) -> Vec<Wanted> {
        let reach =
            |parameters: &Parameters, object: &Object| field_margin(parameters.outer_iso().unwrap_or(object.outer_iso));
        let own = Wanted {
            object: scene.object.clone(),
            reach: reach(&variant.parameters, &scene.object),
            closest: variant.reads_closest(),
            aligned: false,
        };
        let parts = scene.parts.iter().map(|(name, part)| {
            let aligned = part.transform.aligned;
            let up = if aligned { scene.object.up } else { part.object.up };
            Wanted {
                object: Object { up, ..part.object.clone() },
                reach: reach(&variant.parts[name], &part.object),
                closest: variant.part_reads_closest(name),
                aligned,
            }
        });
        [own].into_iter().chain(parts).collect()
    }
}

/// What is computed from a shape, and how it is placed: equal recipes and shapes have equal subjects.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Recipe {
    input: String,
    pub(super) request: field::Request,
    up: Axis,
    closest: bool,
    aligned: bool,
    /// The iso-value of a scan for which none was given.
    proposed_iso: Option<f32>,
}

impl Recipe {
    /// That of an object that is no formula; `scale` is that of the scene's own.
    pub(super) fn of(shape: &Shape, wanted: &Wanted, scale: f32) -> Recipe {
        let Wanted { object, reach, closest, aligned } = wanted;
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
    /// Loads the object of a scene and computes or finds its distance field.
    ///
    /// # Errors
    /// The input cannot be read, or has no surface.
    pub fn load(scene: &Scene, library: &Library, progress: Progress<'_>) -> Result<Subject, RenderError> {
        let own = |wanted: &Wanted, progress: Progress<'_>| Subject::of(wanted, None, progress);
        Subject::all(scene, library, &own, progress)
    }

    /// That of a scene whose own object is a shape in memory: with its field, and the additional objects as the scene names
    /// them. The input of the object becomes [`MEMORY`](shape::MEMORY) and a hash of its contents, by which a picture says
    /// what it shows.
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
        let own = |wanted: &Wanted, progress: Progress<'_>| {
            Subject::made(&shape, Recipe::of(&shape, wanted, 1.0), None, Vec::new(), progress)
        };
        Subject::all(scene, library, &own, progress)
    }

    /// The same of triangles; see [`Mesh::new`](shape::Mesh::new).
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn from_mesh(scene: &mut Scene, library: &Library, mesh: shape::Mesh) -> Result<Subject, RenderError> {
        Subject::from_shape(scene, library, Shape::Mesh(mesh), &|_| ())
    }

    /// The same of samples on a grid; see [`Volume::new`](shape::Volume::new). `object.iso` is the iso-value of scalars.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn from_volume(scene: &mut Scene, library: &Library, volume: shape::Volume) -> Result<Subject, RenderError> {
        Subject::from_shape(scene, library, Shape::Volume(volume), &|_| ())
    }

    /// The same of a distance field, whose samples stay as they are.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn from_field(scene: &mut Scene, library: &Library, field: DistanceField) -> Result<Subject, RenderError> {
        Subject::from_volume(scene, library, field.into_volume())
    }

    /// The same of a function of world space that is negative inside and 0 on the surface; it need be no distance. It is
    /// sampled at the corners of cubes within a box, `object.resolution` along its longest side: what is finer is lost.
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

    /// Its `own` object, then the additional ones as the scene names them.
    fn all(
        scene: &Scene,
        library: &Library,
        own: &dyn Fn(&Wanted, Progress<'_>) -> Result<Subject, RenderError>,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        let objects = Wanted::all(scene, &Variant::of(scene, library)?);
        let count = objects.len() as f32;
        let part = |before: u8| move |done: f32| progress((f32::from(before) + done) / count);
        let mut subject = own(&objects[0], &part(0))?;
        for ((name, wanted), before) in scene.parts.keys().zip(&objects[1..]).zip(1..) {
            let loaded = Subject::of(wanted, Some(&subject), &part(before))?;
            subject.parts.insert(name.clone(), loaded);
        }
        Ok(subject)
    }

    /// Loads an object with a field that reaches `margin` (object units) beyond it, so that several scenes may share it;
    /// with its closest points where one of them reads them.
    ///
    /// # Errors
    /// As [`Subject::load`].
    pub fn load_with_margin(
        object: &Object,
        margin: f32,
        closest: bool,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        let wanted = Wanted { object: object.clone(), reach: field_margin(margin), closest, aligned: false };
        Subject::of(&wanted, None, progress)
    }

    /// An object; `own` is the scene's own one, in whose space an aligned one is.
    fn of(wanted: &Wanted, own: Option<&Subject>, progress: Progress<'_>) -> Result<Subject, RenderError> {
        let Wanted { object, aligned, .. } = wanted;
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

    /// That of a recipe.
    fn made(
        shape: &Shape,
        recipe: Recipe,
        own: Option<&Subject>,
        others: Vec<PathBuf>,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        let Recipe { input, request, up, closest, proposed_iso, .. } = recipe;
        let (field, points, report) = field::load_or_compute(shape, &request, closest, progress)?;
        let field = field.turned(up.turn());
        let points = points.map(|points| points.turned(up.turn()));
        let (low, high) = inside_bounds(&field);
        let offset = if let Shape::Mesh(mesh) = shape { mesh.offset } else { DVec3::ZERO };
        let (center, scale) = match own {
            None => (0.5 * (low + high), 2.0 / (high - low).max_element()),
            Some(own) => (own.center + up.turned(own.offset - offset).as_vec3(), own.scale),
        };
        // Squares of tiny lengths leave f32; a power of two rounds nothing.
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

    /// From object space to the world of its shape, in which its center and size are.
    pub fn world(&self) -> Mat4 {
        Mat4::from_translation(self.center) * Mat4::from_scale(Vec3::splat(1.0 / self.scale))
    }

    /// The other files of all objects.
    pub fn all_others(&self) -> impl Iterator<Item = &PathBuf> {
        self.others.iter().chain(self.parts.values().flat_map(|part| &part.others))
    }
}

/// The shape of an object.
///
/// # Errors
/// The input cannot be read.
pub fn open(object: &Object) -> Result<Shape, ShapeError> {
    Ok(opened(object)?.warned(&object.input))
}

/// The same with what is known of its file besides.
pub(super) fn opened(object: &Object) -> Result<Opened, ShapeError> {
    Ok(settled(Opened::with_grid(&object.input, object.grid.as_deref())?, object))
}

/// What its values are, by what the scene says of them and by the values themselves.
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

/// Whether it is a volume of scalars that was brought.
fn is_scan(shape: &Shape, input: &str) -> bool {
    let is_scalar = matches!(shape, Shape::Volume(volume) if volume.content == shape::Content::Scalar);
    is_scalar && !shape::BUILT_IN.contains(&input)
}

/// The iso-value of a scan that was brought where none is given: the lowest that lies between two materials, which is most
/// often the outside of all; of an object within another the highest.
fn proposed(shape: &Shape, input: &str, within: bool) -> Option<f32> {
    let Shape::Volume(volume) = shape else { return None };
    if !is_scan(shape, input) {
        return None;
    }
    let (low, high) = volume.range();
    let isos: Vec<f32> = volume.iso_values().into_iter().filter(|iso| low < *iso && *iso <= high).collect();
    if within { isos.last().copied() } else { isos.first().copied() }
}

/// The request for a shape's field, in world units. The iso-value of a volume where none is given is the one that is proposed,
/// else the middle of the range.
pub fn request(shape: &Shape, object: &Object, margin: f32) -> field::Request {
    reaching(shape, object, field_margin(margin))
}

/// The same of a field that reaches so far beyond the object, object units.
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

/// How far a field that must reach `margin` beyond its object does reach, object units.
pub fn field_margin(margin: f32) -> f32 {
    (margin.max(0.0) / MARGIN_STEP + 1e-3).ceil().max(1.0) * MARGIN_STEP
}

/// A built-in object that is a formula in `glsl/object`.
fn formula(name: &str) -> Subject {
    let (half_size, radius) = match name {
        _ if name == "cube" || name.starts_with(GLSL) => (Vec3::ONE, 3f32.sqrt()),
        "torus" => (Vec3::new(1.0, 0.3, 1.0), 1.0),
        _ => (Vec3::ONE, 1.0),
    };
    Subject { input: name.into(), scale: 1.0, half_size, radius, ..Subject::default() }
}

/// World positions of the samples inside, or of the nearest to the surface where none is.
fn inside_points(field: &DistanceField) -> impl Iterator<Item = Vec3> + '_ {
    let threshold = field.range().0.max(0.0);
    let [nx, ny, _] = field.grid.size;
    let inside = field.values.iter().enumerate().filter(move |(_, distance)| **distance <= threshold);
    inside.map(move |(index, _)| {
        let index = index as u32;
        field.grid.position(index % nx, index / nx % ny, index / (nx * ny))
    })
}

/// The box around the inside, half a voxel wider on each side.
fn inside_bounds(field: &DistanceField) -> (Vec3, Vec3) {
    let (low, high) =
        inside_points(field).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    (low - 0.5 * field.grid.spacing, high + 0.5 * field.grid.spacing)
}
