//! One model part: its objects, the colors of their corners, and the items of its build.

use super::package::{Element, Package, Step, name};
use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;
use crate::unit::Unit;
use foldhash::HashMap;
use glam::{DAffine3, DVec3};

/// White, opaque; a byte for red, green, blue and opacity.
pub(super) const WHITE: u32 = u32::MAX;

/// Namespaces whose elements are read, or change nothing of a mesh.
const KNOWN: [&str; 4] = ["/core/", "/material/", "/production/", "/slice/"];

/// A model part.
#[derive(Default)]
pub(super) struct Model {
    pub unit: Unit,
    pub objects: HashMap<u32, Object>,
    /// Colors of base materials and color groups.
    colors: HashMap<u32, Vec<u32>>,
    build: Vec<Instance>,
}

/// An object: a mesh, or components.
#[derive(Default)]
pub(super) struct Object {
    pub name: String,
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Colors of the corners of each triangle; empty without colors.
    pub colors: Vec<[u32; 3]>,
    pub components: Vec<Instance>,
    /// Group and index of its color.
    color: [Option<u32>; 2],
}

/// An object at its place.
#[derive(Clone)]
pub(super) struct Instance {
    /// The part with the object, if it is another one.
    pub path: Option<String>,
    pub object: u32,
    pub place: DAffine3,
}

impl Model {
    /// Reads a part of the package.
    pub fn read(source: &Source, package: &mut Package, part: &str) -> Result<Model, ShapeError> {
        let (mut model, mut object, mut group) = (Model::default(), None, None);
        package.each(source, part, &mut |step| {
            match step {
                Step::Start(element) => model.start(source, &element, (&mut object, &mut group))?,
                Step::End(b"object") => model.objects.extend(object.take()),
                Step::End(b"basematerials" | b"colorgroup") => group = None,
                Step::End(_) => {}
            }
            Ok(())
        })?;
        Ok(model)
    }

    /// The items of its build; without any, every object that is no component.
    pub fn items(&self) -> Vec<Instance> {
        if !self.build.is_empty() {
            return self.build.clone();
        }
        let below: Vec<u32> = self.objects.values().flat_map(|own| &own.components).map(|own| own.object).collect();
        let mut free: Vec<u32> = self.objects.keys().copied().filter(|id| !below.contains(id)).collect();
        free.sort_unstable();
        free.into_iter().map(|object| Instance { path: None, object, place: DAffine3::IDENTITY }).collect()
    }

    fn start(
        &mut self,
        source: &Source,
        element: &Element,
        (object, group): (&mut Option<(u32, Object)>, &mut Option<u32>),
    ) -> Result<(), ShapeError> {
        match (element.name(), object) {
            (b"model", _) => self.head(source, element)?,
            (b"basematerials" | b"colorgroup", _) => {
                let id = element.needed(source, "id")?;
                self.colors.insert(id, Vec::new());
                *group = Some(id);
            }
            (b"base", _) => self.color(source, element, *group, "displaycolor")?,
            (b"color", _) => self.color(source, element, *group, "color")?,
            (b"object", object) => {
                let name = element.text(source, "name")?.unwrap_or_default();
                let color = [element.number(source, "pid")?, element.number(source, "pindex")?];
                *object = Some((element.needed(source, "id")?, Object { name, color, ..Object::default() }));
            }
            (b"vertex", Some((_, object))) => {
                let [x, y, z] = ["x", "y", "z"].map(|axis| element.needed(source, axis));
                object.positions.push(DVec3::new(x?, y?, z?));
                source.check_triangles(object.positions.len() as u64 / 3)?;
            }
            (b"triangle", Some((_, object))) => self.triangle(source, element, object)?,
            (b"component", Some((_, object))) => object.components.push(instance(source, element)?),
            (b"item", _) if element.text(source, "printable")?.as_deref() == Some("0") => {
                source.note("items that are not printable are left out".into());
            }
            (b"item", _) => self.build.push(instance(source, element)?),
            _ => {}
        }
        Ok(())
    }

    /// Unit, and extensions without which the file cannot be understood.
    fn head(&mut self, source: &Source, element: &Element) -> Result<(), ShapeError> {
        if let Some(text) = element.text(source, "unit")? {
            let unit = Unit::named(&text);
            self.unit =
                unit.ok_or_else(|| element.malformed(source, "micron to meter, inch or foot as the unit", &text))?;
        }
        for prefix in element.text(source, "requiredextensions")?.unwrap_or_default().split_ascii_whitespace() {
            let space = element.text(source, prefix)?.unwrap_or_default();
            if !KNOWN.iter().any(|known| space.contains(known)) {
                let found = quoted(format!("{prefix} {space}").as_bytes());
                return Err(source.unsupported(
                    Location::Header,
                    "the required extension",
                    found,
                    "export plain meshes",
                ));
            }
        }
        Ok(())
    }

    fn color(
        &mut self,
        source: &Source,
        element: &Element,
        group: Option<u32>,
        attribute: &'static str,
    ) -> Result<(), ShapeError> {
        let Some(colors) = group.and_then(|id| self.colors.get_mut(&id)) else { return Ok(()) };
        let text = element.text(source, attribute)?.unwrap_or_else(|| "#FFFFFF".into());
        let digits = text.strip_prefix('#').filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
        let code = digits.and_then(|digits| match digits.len() {
            6 => u32::from_str_radix(digits, 16).ok().map(|code| code << 8 | 0xff),
            8 => u32::from_str_radix(digits, 16).ok(),
            _ => None,
        });
        colors.push(code.ok_or_else(|| element.malformed(source, "a color as #RRGGBB or #RRGGBBAA", &text))?);
        Ok(())
    }

    fn triangle(&self, source: &Source, element: &Element, object: &mut Object) -> Result<(), ShapeError> {
        let [a, b, c] = ["v1", "v2", "v3"].map(|corner| element.needed::<u32>(source, corner));
        let corners = [a?, b?, c?];
        let count = object.positions.len();
        if let Some(index) = corners.iter().find(|corner| **corner as usize >= count) {
            let found = format!("vertex {index} of {count}, counted from 0");
            return Err(element.malformed(source, "the index of a vertex", &found));
        }
        object.triangles.push(corners);
        source.check_triangles(object.triangles.len() as u64)?;
        let own: Option<u32> = element.number(source, "pid")?;
        let Some(group) = own.or(object.color[0]) else { return Ok(()) };
        let Some(colors) = self.colors.get(&group) else {
            source.note("textures and mixed materials are left out: their triangles are white".into());
            return Ok(());
        };
        let [p1, p2, p3] = ["p1", "p2", "p3"].map(|corner| element.number::<u32>(source, corner));
        let first = p1?.or(object.color[1]);
        let color = |index: Option<u32>| {
            let index = index.unwrap_or_default();
            let missing = || element.malformed(source, "the index of a color", &format!("{index} of {}", colors.len()));
            colors.get(index as usize).copied().ok_or_else(missing)
        };
        // Triangles before the first color are white.
        object.colors.resize(object.triangles.len() - 1, [WHITE; 3]);
        object.colors.push([color(first)?, color(p2?.or(first))?, color(p3?.or(first))?]);
        Ok(())
    }
}

/// An object with its transform: 12 numbers, those of the images of x, y and z, and the shift.
fn instance(source: &Source, element: &Element) -> Result<Instance, ShapeError> {
    let place = match element.text(source, "transform")? {
        None => DAffine3::IDENTITY,
        Some(text) => {
            let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().map(|number| number.parse().ok()).collect();
            let numbers = numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
            let numbers = numbers.and_then(|numbers| <[f64; 12]>::try_from(numbers).ok());
            DAffine3::from_cols_array(
                &numbers.ok_or_else(|| element.malformed(source, "a transform of 12 numbers", &text))?,
            )
        }
    };
    let path = element.text(source, "path")?.map(|path| name(&path));
    Ok(Instance { path, object: element.needed(source, "objectid")?, place })
}
