//! Settings of a scene that do not change its picture.
//!
//! Invariant: no list of names decides. Two pictures are equal if all their inputs are: the linked program without dead
//! code, the values and images that it reads, and the state of drawing. Settings that only affect the time are not
//! listed.

use crate::eval::{self, Fingerprint};
use crate::field::Key;
use crate::noise::Period;
use crate::render::camera::{FrameContext, SubFrame};
use crate::render::error::RenderError;
use crate::render::frame::OpaqueMask;
use crate::render::inputs::{Filter, StoredObjects, blocks, image_key};
use crate::render::subject::{Recipe, Subject, SubjectRequest, opened};
use crate::render::variant::{
    Checkable, GroomImage, OCTAVES_ID, PassImage, Program, Purpose, Resource, SamplerInput, Variant,
};
use crate::scene::schema::{Kind, SETTINGS, Setting, setting};
use crate::scene::{self, Object, Order, Pass, Quality, Scene};
use crate::shader::{Library, Linker};
use crate::shape::Shape;
use blake3::{Hash, Hasher};
use glam::DVec3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::rc::Rc;
use std::sync::Arc;

/// Prefixes of metadata, of settings that always have an effect, and of those of prints.
const ALWAYS_USED: [&str; 8] =
    ["about", "preset", "modules.", "image.", "quality.samples", "object.input", "object.unit", "object.scale_to"];
/// Tables of settings to test.
const TESTED_TABLES: [&str; 5] = ["object", "effect", "material", "light", "camera"];
/// Values that place the vertices of slices.
const VERTEX_VALUES: [&str; 7] =
    ["projection", "texture_matrix", "object_matrix", "display_matrix", "box_min", "box_max", "box_margin"];

/// Fields in which `scene` differs from `base`, as `name = value`, that change no bit of its picture when reset one at
/// a time. `subject` is that of the scene.
///
/// Empty if the scene does not link; undecidable fields are not listed.
pub fn unused_overrides(library: &Library, subject: &Subject, base: &Scene, scene: &impl Checkable) -> Vec<String> {
    let Ok(variant) = scene.checked(library) else { return Vec::new() };
    let (mut comparer, scene) = (PictureComparer::new(library, subject), &variant.scene);
    let before: HashMap<String, String> =
        base.fields().into_iter().map(|(name, value)| (name, value.to_string())).collect();
    let set = scene.fields().into_iter().map(|(name, value)| (name, value.to_string()));
    let set: Vec<(String, String)> = set
        .filter(|(name, value)| before.get(name) != Some(value) && !ALWAYS_USED.iter().any(|b| name.starts_with(b)))
        .collect();
    if set.is_empty() {
        return Vec::new();
    }
    comparer.plain_groom =
        scene.groom.clone().filter(|_| subject.groom.as_ref().is_some_and(|groom| !groom.has_factors()));
    let Ok(own) = comparer.fingerprint(&variant) else { return Vec::new() };
    let changes_nothing = |(name, _): &&(String, String)| {
        let mut without = scene.clone();
        let old = before.get(name).map_or("", String::as_str);
        without.set_field(name, old).is_ok() && comparer.same_picture(&variant, own, &without)
    };
    set.iter().filter(changes_nothing).map(|(name, value)| format!("{name} = {value}")).collect()
}

/// Settings of a scene whose value changes no bit of its picture, since its programs do not read them. Tries the ends
/// of a number's usual range, and all valid choices without parameters of absent modules. A value that selects another
/// program counts as a change. Never lists texts, `quality` or `image`. Returns an empty list when `is_cancelled`
/// returns true.
pub fn unused_settings(
    library: &Library,
    subject: &Subject,
    scene: &Scene,
    is_cancelled: &dyn Fn() -> bool,
) -> Vec<String> {
    let mut comparer = PictureComparer::new(library, subject);
    let Ok(variant) = Variant::of(scene, library) else { return Vec::new() };
    let Ok(own) = comparer.fingerprint(&variant) else { return Vec::new() };
    let values: HashMap<String, String> =
        scene.fields().into_iter().map(|(name, value)| (name, value.to_string())).collect();
    let parts = values.keys().filter(|name| name.starts_with("parts.")).map(String::as_str);
    let names = SETTINGS.iter().map(|setting| setting.name).chain(parts);
    let names = names.filter(|name| !ALWAYS_USED.iter().any(|always| name.starts_with(always)));
    let mut idle = Vec::new();
    for name in names {
        let Some(setting) = setting(name).filter(|setting| TESTED_TABLES.contains(&setting.table())) else { continue };
        if is_cancelled() {
            return Vec::new();
        }
        let with = |other: &String| {
            let mut with = scene.clone();
            with.set_field(name, other).ok()?;
            with.drop_foreign_parameters(library).ok()?;
            if with == *scene { None } else { Variant::of(&with, library).ok() }
        };
        let all = others(library, setting, values.get(name).map_or("", String::as_str));
        let others: Vec<Variant> = all.iter().filter_map(with).collect();
        let changes_nothing = |other: &Variant| {
            let same_program = other.slots == variant.slots && other.entries == variant.entries;
            same_program && comparer.same_picture(&variant, own, other)
        };
        // Without a valid alternative, a module is unused if the program does not reach its slot; other settings are
        // used.
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

/// Whether scenes of one subject all have equal pictures.
pub fn same_pictures(library: &Library, subject: &Subject, mut scenes: impl Iterator<Item = Scene>) -> bool {
    let mut comparer = PictureComparer::new(library, subject);
    let first = scenes.next().and_then(|first| Variant::of(&first, library).ok());
    let first = first.and_then(|first| Some((comparer.fingerprint(&first).ok()?, first)));
    first.is_some_and(|(own, first)| scenes.all(|other| comparer.same_picture(&first, own, &other)))
}

/// Alternative values of a setting, in the syntax of scene files.
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

/// Caches of linked programs and of shapes, for comparisons.
struct PictureComparer<'a> {
    library: &'a Library,
    subject: &'a Subject,
    /// The groom of the scene, if its colors, densities and amounts are not painted.
    plain_groom: Option<String>,
    programs: HashMap<(String, u32), Rc<Read>>,
    /// By all that determines a shape: its input, its grid, and whether its values are distances.
    shapes: HashMap<(String, Option<String>, bool), Rc<Shape>>,
}

/// A program, and its fingerprint if the evaluator covers it.
struct Read {
    program: Program,
    fingerprint: Option<(eval::Program, Fingerprint)>,
}

impl<'a> PictureComparer<'a> {
    fn new(library: &'a Library, subject: &'a Subject) -> PictureComparer<'a> {
        PictureComparer { library, subject, plain_groom: None, programs: HashMap::new(), shapes: HashMap::new() }
    }

    /// Whether another scene has an equal picture; `own` is the fingerprint of the first. Undecidable pictures differ.
    fn same_picture(&mut self, variant: &Variant, own: Hash, other: &impl Checkable) -> bool {
        let Ok(other) = other.checked(self.library) else { return false };
        let same = self.same_subject(variant, &other).and_then(|same| Ok(same && self.fingerprint(&other)? == own));
        same.unwrap_or(false)
    }

    /// Whether two scenes have equal objects.
    fn same_subject(&mut self, variant: &Variant, other: &Variant) -> Result<bool, RenderError> {
        let mut same = variant.parts.keys().eq(other.parts.keys());
        for (own, other) in SubjectRequest::all(variant).iter().zip(&SubjectRequest::all(other)) {
            same = same && self.same_object(own, other)?;
        }
        Ok(same)
    }

    fn same_object(&mut self, own: &SubjectRequest, other: &SubjectRequest) -> Result<bool, RenderError> {
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

    /// Shape and field recipe of an object.
    fn recipe(&mut self, wanted: &SubjectRequest) -> Result<(Rc<Shape>, Recipe), RenderError> {
        let Object { input, grid, distance, .. } = &wanted.object;
        let shape = match self.shapes.entry((input.clone(), grid.clone(), *distance)) {
            Entry::Occupied(known) => known.get().clone(),
            Entry::Vacant(new) => new.insert(Rc::new(opened(&wanted.object)?.shape)).clone(),
        };
        let recipe = Recipe::of(&shape, wanted, self.subject.scale);
        Ok((shape, recipe))
    }

    /// The variant without a plain groom, if its program reads colors, densities and amounts alone: they are factors of 1.
    fn without_plain_groom(&mut self, variant: &Variant) -> Result<Variant, RenderError> {
        let scene = &variant.scene;
        // Weights of the shader need not have the sum 1.
        let is_exact = scene.quality.filter == scene::Filter::Exact;
        if scene.groom.is_none() || scene.groom != self.plain_groom || is_exact {
            return Ok(variant.clone());
        }
        let read = self.read(variant)?;
        let images = read.fingerprint.iter().flat_map(|(_, own)| &own.images);
        let images: Vec<u32> = images.map(|(image, _)| *image).collect();
        let reads = |image: GroomImage| read.program.image(image).is_some_and(|own| images.contains(&own));
        if (reads(GroomImage::Look) || reads(GroomImage::Amount)) && !reads(GroomImage::Shape) {
            Ok(Variant::of(&Scene { groom: None, ..scene.clone() }, self.library)?)
        } else {
            Ok(variant.clone())
        }
    }

    /// Hash of all that the pictures of a scene are computed from.
    fn fingerprint(&mut self, variant: &Variant) -> Result<Hash, RenderError> {
        let mut variant = self.without_plain_groom(variant)?;
        if variant.module("classify").is_some_and(|module| module.starts_with("surface")) {
            // Of opaque matter only the nearest sample is seen, in any order.
            (variant.scene.quality.order, variant.scene.quality.early_termination) = (Order::default(), 0.0);
        }
        let mut read = self.read(&variant)?;
        // The border mode only matters for blocks and for noise with a period.
        if !read.program.reads(SamplerInput::Block.binding())
            && variant.periods.iter().all(|period| *period == Period::ENDLESS)
            && let Some(wrap) = Arc::make_mut(&mut variant.slots).get_mut("wrap")
        {
            *wrap = vec!["repeat".into()];
            read = self.read(&variant)?;
        }
        let frame = FrameContext::of(variant, self.subject);
        let (variant, scene) = (&frame.variant, &frame.variant.scene);
        let stored = StoredObjects::none(&frame.view);
        let values = |sub_frame: SubFrame| stored.values(&frame, &sub_frame);
        let moments: Vec<_> = SubFrame::all(scene).map(values).collect();
        let mut all = Hasher::new();
        let mut add = |what: String| {
            all.update(what.as_bytes());
        };
        // Other settings act through the program, its values and its images.
        let Quality { pass, target, order, proxy, early_termination, msaa, .. } = &scene.quality;
        add(format!("{:?} {:?} {msaa} {target:?} {}", scene.entries(), scene.image.size, moments.len()));
        if *pass == Pass::Slices {
            add(format!("{order:?} {proxy:?} {:?} {:?} {:?}", frame.planes, frame.view.extent, frame.view.axis));
            add(format!("{:?} {}", read.program.vertex, scene.camera.slice_stack));
            if OpaqueMask::serve(scene) {
                add(format!("{early_termination}"));
            }
            for values in &moments {
                add(format!("{:?}", VERTEX_VALUES.map(|name| values.named.get(name))));
            }
        }
        let mut programs = vec![(read.clone(), false)];
        if read.program.reads_image(PassImage::Shadow) {
            programs.push((self.read(&variant.for_purpose(Purpose::Shadow, self.library)?)?, true));
        }
        if scene.is_half_angle() {
            programs.push((self.read(&variant.for_purpose(Purpose::Light, self.library)?)?, false));
        }
        if programs.len() > 1 {
            add(format!("{:?}", frame.space.target()));
        }
        for (read, casts) in programs {
            let resources = &read.program.resources;
            let resource = |binding: u32| resources.iter().find(|own| own.binding == binding);
            let pairs = match &read.fingerprint {
                Some((_, fingerprint)) => fingerprint.images.clone(),
                None => resources.iter().map(|own| (own.binding, Some(own.binding))).collect(),
            };
            for (binding, sampler) in pairs {
                let Some((image, object)) = resource(binding).and_then(Resource::image) else { continue };
                if image == PassImage::Cells.into() {
                    continue;
                }
                add(format!("{image:?} {object} {}", image_key(&frame, object, image)));
                if let Some(sampler) = sampler.and_then(resource) {
                    add(format!("{:?}", Filter::of(sampler.sampler().unwrap_or_default(), &scene.quality)));
                }
            }
            let mut before = String::new();
            for values in &moments {
                let blocks = blocks(&read.program, values)?;
                let known = read.fingerprint.as_ref().map(|(program, own)| (own.hash, program.values(own, &blocks)));
                let drawn = match known {
                    Some((hash, Ok(values))) => format!("{hash} {values:?}"),
                    _ => format!("{:?} {} {blocks:?}", read.program.fragment, scene.effect.octaves),
                };
                // Shadows are cast once for a resting scene, else for each sub-frame whose values differ from the
                // previous.
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

    fn read(&mut self, variant: &Variant) -> Result<Rc<Read>, RenderError> {
        let octaves = variant.scene.effect.octaves;
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
