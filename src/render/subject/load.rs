//! The loaded object of a scene: distance field, placement and size.

use super::request::{Recipe, SubjectRequest, field_margin, opened, settled};
use crate::field::{self, ClosestPoints, DistanceField, Progress};
use crate::render::error::RenderError;
use crate::render::variant::{Checkable, Variant};
use crate::scene::{GLSL, Object, Scene};
use crate::shader::Library;
use crate::shape::{self, Groom, Opened, Shape};
use glam::{DVec3, Mat3, Mat4, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
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
    /// Unit of the coordinates of its file.
    pub unit: Option<shape::Unit>,
    /// Report on the computation of the field.
    pub report: Option<field::FieldReport>,
    /// Iso-value chosen for a scan without a given one.
    pub proposed_iso: Option<f32>,
    /// Files read besides the named one: the data of a header, the slices of a series.
    pub others: Vec<PathBuf>,
    /// Groom painted on the object.
    pub groom: Option<Arc<Groom>>,
    /// The additional objects of the scene, each in its own space.
    pub parts: BTreeMap<String, Subject>,
}

impl Subject {
    /// Loads the object of a scene and computes its distance field or finds it in the cache.
    ///
    /// # Errors
    /// The input cannot be read, or has no surface.
    pub fn load(scene: &impl Checkable, library: &Library, progress: Progress<'_>) -> Result<Subject, RenderError> {
        let own = |wanted: &SubjectRequest, progress: Progress<'_>| Subject::of(wanted, None, progress);
        Subject::all(&*scene.checked(library)?, &own, progress)
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
        let shape = settled(Opened::from(shape), &scene.object).warned(&scene.object.input);
        let own = |wanted: &SubjectRequest, progress: Progress<'_>| {
            Subject::made(&shape, Recipe::of(&shape, wanted, 1.0), None, Vec::new(), progress)
        };
        Subject::all(&Variant::of(scene, library)?, &own, progress)
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
        variant: &Variant,
        own: &dyn Fn(&SubjectRequest, Progress<'_>) -> Result<Subject, RenderError>,
        progress: Progress<'_>,
    ) -> Result<Subject, RenderError> {
        let objects = SubjectRequest::all(variant);
        let count = objects.len() as f32;
        let part = |before: u8| move |done: f32| progress((f32::from(before) + done) / count);
        let mut subject = own(&objects[0], &part(0))?;
        subject.groom = variant.scene.groom.as_deref().map(|file| groom(file, &subject.input)).transpose()?;
        for ((name, wanted), before) in variant.parts.keys().zip(&objects[1..]).zip(1..) {
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
        let (others, unit) = (std::mem::take(&mut opened.others), opened.unit);
        let shape = opened.warned(&object.input);
        let recipe = Recipe::of(&shape, wanted, own.map_or(1.0, |own| own.scale));
        Ok(Subject { unit, ..Subject::made(&shape, recipe, own, others, progress)? })
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
        let (field, points, report) = field::load_or_compute(shape, &request, closest, progress)?;
        let field = field.turned(up.turn());
        let points = points.map(|points| points.turned(up.turn()));
        let (low, high) = inside_bounds(&field);
        let offset = if let Shape::Mesh(mesh) = shape { mesh.offset } else { DVec3::ZERO };
        let (center, scale) = match own {
            None => (0.5 * (low + high), 2.0 / (high - low).max_element()),
            Some(own) => (own.center + up.turned(own.offset - offset).as_vec3(), own.scale),
        };
        if scale.is_infinite() {
            return Err(RenderError::Tiny(input, (high - low).max_element()));
        }
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
            unit: None,
            report,
            proposed_iso,
            others,
            groom: None,
            parts,
        })
    }

    /// Largest strength of warps and DMFs that is painted, at least 1.
    pub(crate) fn strength(&self) -> f32 {
        self.groom.as_ref().map_or(1.0, |groom| groom.strongest().max(1.0))
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

/// Reads the groom of an object.
fn groom(file: &str, object: &str) -> Result<Arc<Groom>, RenderError> {
    let groom = Groom::read(Path::new(file))?;
    let name = |path: &str| Path::new(path).file_name().map(|name| name.to_os_string());
    if name(&groom.object) != name(object) {
        log::warn!("groom {file}: it was painted on {}; it is read at the same places of {object}", groom.object);
    }
    for line in groom.odd_values() {
        log::warn!("groom {file}: {line}");
    }
    Ok(Arc::new(groom))
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
