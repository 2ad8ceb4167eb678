//! Fields of a scene that change nothing in its picture.
//!
//! Role: a scene, and the one that it was made of -> the fields that were set and might as well not be. Invariant: no list
//! of names says which. Two pictures are the same where all that they are computed from is: what the linked program does,
//! the values and images that it reads after all that is dead is gone, and how it is drawn. What only makes a picture
//! sooner is not named.

use super::encoded::Filter;
use super::inputs::{CELLS, SHADOW, StoredObjects, image_key};
use super::marks::Marks;
use super::shot::Shot;
use super::sub_frame::SubFrame;
use super::subject::{Recipe, Wanted, opened};
use super::values::blocks;
use super::{OCTAVES_ID, RenderError, Subject};
use crate::eval::{self, Fingerprint};
use crate::field::Key;
use crate::noise::Period;
use crate::render::variant::{Program, Variant};
use crate::scene::schema::{Kind, SETTINGS, Setting, setting};
use crate::scene::{Object, Order, Pass, Quality, Scene};
use crate::shader::{Library, Linker};
use crate::shape::Shape;
use blake3::{Hash, Hasher};
use glam::DVec3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::rc::Rc;

/// Fields that say something about a scene, or always do something.
const BESIDE: [&str; 6] = ["about", "preset", "modules.", "image.", "quality.samples", "object.input"];
/// The tables of settings that are looked at for what is idle.
const LOOKED_AT: [&str; 5] = ["object", "effect", "material", "light", "camera"];
/// What the vertices of slices are placed by.
const VERTEX_VALUES: [&str; 7] =
    ["projection", "texture_matrix", "object_matrix", "display_matrix", "box_min", "box_max", "box_margin"];

/// The fields in which `scene` differs from `base`, as `name = value`, that change no bit of its picture: without any one
/// of them it is the same. `subject` is that of the scene.
///
/// A scene that has no program has no such fields, and what cannot be decided is none.
pub fn ignored(library: &Library, subject: &Subject, base: &Scene, scene: &Scene) -> Vec<String> {
    let mut judge = Judge::new(library, subject);
    let before: HashMap<String, String> =
        base.fields().into_iter().map(|(name, value)| (name, value.to_string())).collect();
    let set = scene.fields().into_iter().map(|(name, value)| (name, value.to_string()));
    let set: Vec<(String, String)> = set
        .filter(|(name, value)| before.get(name) != Some(value) && !BESIDE.iter().any(|b| name.starts_with(b)))
        .collect();
    if set.is_empty() {
        return Vec::new();
    }
    let Ok(own) = judge.essence(scene) else { return Vec::new() };
    let changes_nothing = |(name, _): &&(String, String)| {
        let mut without = scene.clone();
        let old = before.get(name).map_or("", String::as_str);
        without.set_field(name, old).is_ok() && judge.same_picture(scene, own, &without)
    };
    set.iter().filter(changes_nothing).map(|(name, value)| format!("{name} = {value}")).collect()
}

/// The settings of a scene that change no bit of its picture, whatever they are: what its programs do not read. Of a number,
/// the ends of its usual range are tried, of a choice all that the scene allows without the parameters of modules that are
/// gone; a value that chooses another program is taken to change the picture. Settings of how it is drawn (`quality`, `image`) are never named, nor is text. `is_over` ends
/// it early, with none.
pub fn idle(library: &Library, subject: &Subject, scene: &Scene, is_over: &dyn Fn() -> bool) -> Vec<String> {
    let mut judge = Judge::new(library, subject);
    let (Ok(variant), Ok(own)) = (Variant::of(scene, library), judge.essence(scene)) else { return Vec::new() };
    let values: HashMap<String, String> =
        scene.fields().into_iter().map(|(name, value)| (name, value.to_string())).collect();
    let parts = values.keys().filter(|name| name.starts_with("parts.")).map(String::as_str);
    let names = SETTINGS.iter().map(|setting| setting.name).chain(parts);
    let mut idle = Vec::new();
    for name in names {
        let Some(setting) = setting(name).filter(|setting| LOOKED_AT.contains(&setting.table())) else { continue };
        if is_over() {
            return Vec::new();
        }
        let with = |other: &String| {
            let mut with = scene.clone();
            with.set_field(name, other).ok()?;
            with.drop_foreign_parameters(library).ok()?;
            (with != *scene && with.check(library).is_ok()).then_some(with)
        };
        let all = others(library, setting, values.get(name).map_or("", String::as_str));
        let others: Vec<Scene> = all.iter().filter_map(with).collect();
        let changes_nothing = |other: &Scene| {
            let same_program =
                Variant::of(other, library).is_ok_and(|of| of.key() == variant.key() && of.entries == variant.entries);
            same_program && judge.same_picture(scene, own, other)
        };
        // Where the scene refuses every other value, a module that the program does not reach is not read, and all else is.
        let is_idle = match others.as_slice() {
            [] => matches!(setting.kind, Kind::Module(_)) && !variant.reads(setting.field()),
            others => others.iter().all(changes_nothing),
        };
        if is_idle {
            idle.push(name.to_string());
        }
    }
    idle
}

/// Whether scenes of one subject all have the same picture.
pub fn all_alike(library: &Library, subject: &Subject, mut scenes: impl Iterator<Item = Scene>) -> bool {
    let mut judge = Judge::new(library, subject);
    let first = scenes.next().and_then(|first| Some((judge.essence(&first).ok()?, first)));
    first.is_some_and(|(own, first)| scenes.all(|other| judge.same_picture(&first, own, &other)))
}

/// What else a setting may be, as a scene file has it.
fn others(library: &Library, setting: &Setting, value: &str) -> Vec<String> {
    let quoted = |name: &str| format!("{name:?}");
    let many = |count: usize, number: f32| format!("[{}]", vec![number.to_string(); count].join(", "));
    let mut others: Vec<String> = match setting.kind {
        _ if value.is_empty() => setting.optional.iter().map(|on| on.to_string()).collect(),
        Kind::Number(range) if range.is_all() => vec!["0".into(), "1".into()],
        Kind::Number(range) | Kind::Whole(range) => range.usual.map(|end| end.to_string()).into(),
        Kind::Numbers(count, range) if range.is_all() => [0.25, 0.5].map(|number| many(count, number)).into(),
        Kind::Numbers(count, range) | Kind::Wholes(count, range) => range.usual.map(|end| many(count, end)).into(),
        Kind::OneOf(numbers) => numbers.iter().map(u32::to_string).collect(),
        Kind::Switch => vec!["true".into(), "false".into()],
        Kind::Choice(choices) => choices.iter().map(|(name, _)| quoted(name)).collect(),
        Kind::Color => ["#123456", "#fedcba"].map(quoted).into(),
        Kind::Module(_) => library.modules(setting.field()).into_iter().map(quoted).collect(),
        Kind::Text | Kind::Stack | Kind::Stops => Vec::new(),
    };
    others.retain(|other| other != value);
    others
}

/// What programs do, each linked once, and the shapes of objects, each read once.
struct Judge<'a> {
    library: &'a Library,
    subject: &'a Subject,
    programs: HashMap<(String, u32), Rc<Read>>,
    /// By all that a shape is read by: its input, its grid, and whether its values are distances.
    shapes: HashMap<(String, Option<String>, bool), Rc<Shape>>,
}

/// A program, and what it does, where the evaluator covers it.
struct Read {
    program: Program,
    fingerprint: Option<(eval::Program, Fingerprint)>,
}

impl<'a> Judge<'a> {
    fn new(library: &'a Library, subject: &'a Subject) -> Judge<'a> {
        Judge { library, subject, programs: HashMap::new(), shapes: HashMap::new() }
    }

    /// Whether another scene has the picture of a scene, whose essence is `own`. What cannot be decided has another.
    fn same_picture(&mut self, scene: &Scene, own: Hash, other: &Scene) -> bool {
        let same = self.same_subject(scene, other).and_then(|same| Ok(same && self.essence(other)? == own));
        same.unwrap_or(false)
    }

    /// Whether two scenes have the same objects: what their fields are computed from is equal.
    fn same_subject(&mut self, scene: &Scene, other: &Scene) -> Result<bool, RenderError> {
        let wanted = |scene| Ok::<_, RenderError>(Wanted::all(scene, &Variant::of(scene, self.library)?));
        let (own, others) = (wanted(scene)?, wanted(other)?);
        let mut same = scene.parts.keys().eq(other.parts.keys());
        for (own, other) in own.iter().zip(&others) {
            same = same && self.same_object(own, other)?;
        }
        Ok(same)
    }

    fn same_object(&mut self, own: &Wanted, other: &Wanted) -> Result<bool, RenderError> {
        if own == other {
            return Ok(true);
        }
        match [own, other].map(|wanted| wanted.object.is_formula()) {
            [true, true] => return Ok(own.object.input == other.object.input),
            [false, false] if own.object != other.object => {}
            _ => return Ok(false),
        }
        let ((shape, recipe), (other_shape, other)) = (self.recipe(own)?, self.recipe(other)?);
        let offset = |shape: &Shape| if let Shape::Mesh(mesh) = shape { mesh.offset } else { DVec3::ZERO };
        let key = |shape: &Shape, recipe: &Recipe| (offset(shape), Key::new(shape, &recipe.request));
        let mut placed = recipe.clone();
        placed.request = other.request;
        Ok(placed == other && key(&shape, &recipe) == key(&other_shape, &other))
    }

    /// The shape of an object, and what is made of it.
    fn recipe(&mut self, wanted: &Wanted) -> Result<(Rc<Shape>, Recipe), RenderError> {
        let Object { input, grid, distance, .. } = &wanted.object;
        let shape = match self.shapes.entry((input.clone(), grid.clone(), *distance)) {
            Entry::Occupied(known) => known.get().clone(),
            Entry::Vacant(new) => new.insert(Rc::new(opened(&wanted.object)?.shape)).clone(),
        };
        let recipe = Recipe::of(&shape, wanted, self.subject.scale);
        Ok((shape, recipe))
    }

    /// All that the pictures of a scene are computed from.
    fn essence(&mut self, scene: &Scene) -> Result<Hash, RenderError> {
        let mut variant = Variant::of(scene, self.library)?;
        let mut scene = scene.clone();
        if variant.module("classify").is_some_and(|module| module.starts_with("surface")) {
            // Of matter that is opaque or none the nearest is seen, in any order and alone.
            (scene.quality.order, scene.quality.early_termination) = (Order::default(), 0.0);
        }
        let scene = &scene;
        let mut read = self.read(scene, &variant)?;
        // What neither is a block nor repeats as one has no border.
        if !read.program.reads("block_sampler")
            && variant.periods.iter().all(|period| *period == Period::ENDLESS)
            && let Some(wrap) = variant.slots.get_mut("wrap")
        {
            *wrap = vec!["repeat".into()];
            read = self.read(scene, &variant)?;
        }
        let shot = Shot::of(scene, self.subject, &variant);
        let stored = StoredObjects::none(&shot.view);
        let values = |frame: SubFrame| stored.values(&shot, &frame);
        let moments: Vec<_> = SubFrame::all(scene).map(values).collect();
        let mut all = Hasher::new();
        let mut add = |what: String| {
            all.update(what.as_bytes());
        };
        // Each setting is added here, or acts by the program, its values and its images alone.
        let Quality {
            pass,
            target,
            order,
            proxy,
            early_termination,
            msaa,
            samples: _,
            supersampling: _,
            integration: _,
            empty_space: _,
            neutral: _,
            reject: _,
            jitter: _,
            seed: _,
            filter: _,
            anisotropy: _,
            block_size: _,
            turbulence_cells: _,
            wrap: _,
            block_format: _,
            block_blur: _,
        } = &scene.quality;
        add(format!("{:?} {:?} {msaa} {target:?} {}", scene.entries(), scene.image.size, moments.len()));
        if *pass == Pass::Slices {
            add(format!("{order:?} {proxy:?} {:?} {:?} {:?}", shot.planes, shot.view.extent, shot.view.axis));
            add(format!("{:?} {}", read.program.vertex, scene.camera.slice_stack));
            if Marks::serve(scene) {
                add(format!("{early_termination}"));
            }
            for values in &moments {
                add(format!("{:?}", VERTEX_VALUES.map(|name| values.get(name))));
            }
        }
        let mut programs = vec![(read.clone(), false)];
        if read.program.reads(SHADOW) {
            programs.push((self.read(scene, &variant.shadow(scene, self.library)?)?, true));
        }
        if scene.is_half_angle() {
            programs.push((self.read(scene, &variant.light(scene, self.library)?)?, false));
        }
        if programs.len() > 1 {
            add(format!("{:?}", shot.space.target()));
        }
        for (read, casts) in programs {
            let names: HashMap<u32, &str> =
                read.program.resources.iter().map(|resource| (resource.binding, resource.name.as_str())).collect();
            let name = |binding: u32| names.get(&binding).copied().unwrap_or_default();
            let pairs = match &read.fingerprint {
                Some((_, fingerprint)) => fingerprint.images.clone(),
                None => {
                    read.program.resources.iter().map(|resource| (resource.binding, Some(resource.binding))).collect()
                }
            };
            for (image, sampler) in
                pairs.into_iter().filter(|(image, _)| name(*image).contains("_image") && name(*image) != CELLS)
            {
                let key = image_key(&shot, name(image));
                add(format!("{} {key}", name(image)));
                if let Some(sampler) = sampler {
                    add(format!("{:?}", Filter::of(name(sampler), &scene.quality)));
                }
            }
            let mut before = String::new();
            for values in &moments {
                let blocks = blocks(&read.program, values)?.into_iter();
                let blocks = blocks.map(|(resource, bytes)| (resource.binding, bytes)).collect();
                let known = read
                    .fingerprint
                    .as_ref()
                    .map(|(program, fingerprint)| (fingerprint, program.values(fingerprint, &blocks)));
                let drawn = match known {
                    Some((fingerprint, Ok(values))) => format!("{} {values:?}", fingerprint.hash),
                    _ => format!("{:?} {} {blocks:?}", read.program.fragment, scene.effect.octaves),
                };
                // Shadows are cast once, or for each moment; from equal values they are the same.
                if !casts || drawn != before {
                    add(drawn.clone());
                }
                if casts && scene.camera.shutter == 0.0 {
                    break;
                }
                before = drawn;
            }
        }
        Ok(all.finalize())
    }

    fn read(&mut self, scene: &Scene, variant: &Variant) -> Result<Rc<Read>, RenderError> {
        let octaves = scene.effect.octaves;
        let key = (format!("{:?} {}", variant.entries, variant.key()), octaves);
        if let Some(known) = self.programs.get(&key) {
            return Ok(known.clone());
        }
        let program = variant.program(self.library, Linker::new)?;
        let fingerprint = eval::Program::read(&program.fragment, &[(OCTAVES_ID, octaves)]).ok().map(|read| {
            let fingerprint = read.fingerprint();
            (read, fingerprint)
        });
        let read = Rc::new(Read { program, fingerprint });
        self.programs.insert(key, read.clone());
        Ok(read)
    }
}
