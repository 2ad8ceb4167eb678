//! 3D Manufacturing Format (3MF): the items of its build as one mesh.
//!
//! Role: meshes, components, base materials and color groups; parts of other files of the package. Invariant: memory is bounded
//! by the length of the file. Sources: 3MF Consortium, "Core Specification" 1.4, "Materials and Properties Extension" 1.2,
//! "Production Extension" 1.1.

mod model;
mod package;

use crate::error::{Location, ShapeError, quoted};
use crate::shape::looks::linear;
use crate::shape::{Mesh, Shape};
use crate::source::{Source, check_positions};
use foldhash::{HashMap, HashMapExt};
use glam::{DAffine3, DVec3};
use model::{Instance, Model, Object};
use package::Package;
use std::collections::BTreeMap;

/// Objects within objects. Higher: a circle takes longer to find.
const MAX_DEPTH: usize = 32;
/// Placed objects, those without a mesh too.
const MAX_PLACED: usize = 1 << 17;

/// Whether the file begins as a ZIP archive; no other format here is one.
pub(crate) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.starts_with(b"PK\x03\x04")
}

/// Reads the meshes of all items that are to be printed, colors of their corners as colors of vertices.
///
/// Textures and composite materials are left out, with a note.
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let mut package = Package::open(source)?;
    let root = package.root(source)?;
    let mut models = BTreeMap::from([(root.clone(), Model::read(source, &mut package, &root)?)]);
    let placed = placed(source, &mut package, &root, &mut models)?;
    source.unit.set(Some(models[&root].unit));
    let objects: Vec<(&Object, DAffine3)> =
        placed.iter().map(|(path, id, world)| (&models[path].objects[id], *world)).collect();
    source.names = objects.iter().map(|(object, _)| object.name.clone()).filter(|name| !name.is_empty()).collect();
    let are_colored = objects.iter().any(|(object, _)| !object.colors.is_empty());
    let mut found = Found::default();
    for (object, world) in objects {
        source.check_triangles((found.triangles.len() + object.triangles.len()) as u64)?;
        found.add(object, world, are_colored);
    }
    check_positions(&source.file, "vertices", &found.positions)?;
    let holds = format!("{} objects in its build", placed.len());
    source.finish(Mesh::cleaned_with(&found.positions, &found.colors, &[], found.triangles), holds)
}

/// An object of a part, and where it stands.
type Placed = (String, u32, DAffine3);

/// All objects with triangles that the build holds; further parts are read as they are met.
fn placed(
    source: &mut Source,
    package: &mut Package,
    root: &str,
    models: &mut BTreeMap<String, Model>,
) -> Result<Vec<Placed>, ShapeError> {
    let (mut waiting, mut placed, mut visits) = (Vec::new(), Vec::new(), 0);
    let at = |path: &str, item: &Instance| item.path.clone().unwrap_or_else(|| path.into());
    waiting.extend(models[root].items().iter().rev().map(|item| (at(root, item), item.object, item.place, 0)));
    while let Some((path, id, world, depth)) = waiting.pop() {
        if !models.contains_key(&path) {
            models.insert(path.clone(), Model::read(source, package, &path)?);
        }
        let place = || Location::Part(path.clone(), 0);
        let Some(object) = models[&path].objects.get(&id) else {
            return Err(source.malformed_at(
                place(),
                "the object of each item and component",
                format!("no object {id}"),
            ));
        };
        visits += 1;
        if depth > MAX_DEPTH || visits > MAX_PLACED {
            let found = format!("more than {MAX_DEPTH} levels or {MAX_PLACED} objects at object {id}");
            return Err(source.malformed_at(place(), "components without a circle", found));
        }
        let below = object.components.iter().rev();
        waiting.extend(below.map(|item| (at(&path, item), item.object, world * item.place, depth + 1)));
        if !object.triangles.is_empty() {
            placed.push((path, id, world));
        }
    }
    Ok(placed)
}

/// Triangles of all objects.
#[derive(Default)]
struct Found {
    positions: Vec<DVec3>,
    colors: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Found {
    /// Adds an object; where colors meet at a vertex, it becomes one for each.
    fn add(&mut self, object: &Object, world: DAffine3, are_colored: bool) {
        let mirrored = world.matrix3.determinant() < 0.0;
        let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        let first = self.positions.len() as u32;
        if !are_colored {
            self.positions.extend(object.positions.iter().map(|position| world.transform_point3(*position)));
            self.triangles.extend(object.triangles.iter().map(|corners| turned(corners.map(|corner| first + corner))));
            return;
        }
        let mut known: HashMap<(u32, u32), u32> = HashMap::with_capacity(object.positions.len());
        for (index, corners) in object.triangles.iter().enumerate() {
            let colors = object.colors.get(index).copied().unwrap_or([model::WHITE; 3]);
            let corners = [0, 1, 2].map(|corner| {
                *known.entry((corners[corner], colors[corner])).or_insert_with(|| {
                    self.positions.push(world.transform_point3(object.positions[corners[corner] as usize]));
                    let [red, green, blue, _] = colors[corner].to_be_bytes();
                    self.colors.push([red, green, blue].map(|code| linear(f64::from(code) / 255.0)));
                    self.positions.len() as u32 - 1
                })
            });
            self.triangles.push(turned(corners));
        }
    }
}

/// A part of the package that is not as the specification says.
fn malformed(source: &Source, (part, byte): (&str, u64), expected: &'static str, found: &str) -> ShapeError {
    source.malformed_at(Location::Part(part.into(), byte), expected, quoted(found.as_bytes()))
}
