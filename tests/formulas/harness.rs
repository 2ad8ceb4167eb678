//! A check: a module shown by a few lines of GLSL, evaluated in f64 at 10^4 points, and held against a formula.

use crate::formulas::values::{Random, Setting};
use glam::DVec3;
use hypertexture::eval::{Inputs, Invocations, Program, Texture, Wrap};
use hypertexture::render::variant::{self, Use, Variant};
use hypertexture::scene::{ParameterValue, Scene, preset};
use hypertexture::shader::{self, Library, Linker};
use std::collections::BTreeMap;

/// Harness of a check: the inputs `p0` to `p3` of a point, the outputs `out0` and `out1`.
const ENTRY: &str = "#version 450
#include \"interface.glsl\"
#include \"vector.glsl\"
layout(location = 0) in vec4 p0;
layout(location = 1) in vec4 p1;
layout(location = 2) in vec4 p2;
layout(location = 3) in vec4 p3;
layout(location = 0) out vec4 out0;
layout(location = 1) out vec4 out1;
vec3 position_eye;
vec4 color = vec4(0.5, 0.75, 1.0, 1.0);
bool follows = false;
mat3 ray_basis;
#include <projection>
CHECK
void main() {
    position_eye = p3.xyz;
    ray_basis = ray_basis_of();
    out0 = out1 = vec4(0.0);
    check();
}
";

/// The vertex color of [`ENTRY`].
pub const COLOR: DVec3 = DVec3::new(0.5, 0.75, 1.0);

/// Modules of the slots that a check does not fill, where they differ from those of the default scene.
const SLOTS: [(&str, &str); 10] = [
    ("boolean", "algebraic"),
    ("classify", "soft"),
    ("empty_space", "sample"),
    ("noise", "procedural"),
    ("object", "sphere"),
    ("project", "formula"),
    ("ray_path", "straight"),
    ("softness", "linear"),
    ("surface", "unlit"),
    ("turbulence", "procedural"),
];

/// Values of the parameters, and points for each.
const SETTINGS: u64 = 32;
const POINTS: usize = 320;
/// The octaves of turbulence, a constant of the program: not its default.
pub const OCTAVES: u32 = 6;

/// A point: what it was given, and the values of the parameters.
pub struct At<'a> {
    pub p: [[f64; 4]; 4],
    setting: &'a Setting,
    textures: &'a BTreeMap<String, Texture>,
}

impl At<'_> {
    /// The first three components of an input.
    pub fn place(&self, input: usize) -> DVec3 {
        DVec3::from_slice(&self.p[input])
    }

    pub fn number(&self, name: &str) -> f64 {
        self.setting.number(name)
    }

    pub fn vector(&self, name: &str) -> DVec3 {
        self.setting.vector(name)
    }

    /// An image, if the program reads it.
    pub fn image(&self, name: &str) -> Option<&Texture> {
        self.textures.get(name)
    }

    pub fn texture(&self, name: &str) -> &Texture {
        &self.textures[name]
    }
}

impl std::ops::Deref for At<'_> {
    type Target = Setting;
    fn deref(&self) -> &Setting {
        self.setting
    }
}

/// Generator of the inputs of a point.
type Give = Box<dyn Fn(&mut Random, &Setting) -> [[f64; 4]; 4]>;

pub struct Check {
    linked: variant::Program,
    setting: Setting,
    textures: BTreeMap<String, Texture>,
    give: Give,
}

impl Check {
    /// A check of the modules in `slots`, shown by the function `void check()` of `text`.
    pub fn new(library: &Library, slots: &[(&str, &str)], text: &str) -> Check {
        let library = library.clone().with_module("check", "entry", &ENTRY.replace("CHECK", text));
        let entries = ["march.vert", "check/entry.glsl"];
        let names = |modules: &str| modules.split('+').filter(|name| *name != "-").map(String::from).collect();
        let mut choice = Scene::default().slots(&library);
        choice.extend(SLOTS.iter().chain(slots).map(|(slot, modules)| (slot.to_string(), names(modules))));
        let slots = library.needed(&entries, &choice).unwrap();
        let mut parameters = library.declarations(&entries, &slots).unwrap().parameters;
        for (part, _) in choice.keys().filter_map(|key| key.split_once('.')) {
            let own = library.object_declarations(part, &slots).unwrap().parameters;
            parameters.extend(
                own.into_iter()
                    .map(|parameter| shader::Parameter { name: format!("{}_{part}", parameter.name), ..parameter }),
            );
        }
        let any = Variant::of(&preset("lit").unwrap(), &shader::shipped()).unwrap();
        let variant = Variant { entries, slots: slots.into(), ..any };
        let linked = variant.program(&library, Linker::new).unwrap_or_else(|error| panic!("{error}"));
        let images = linked.resources.iter().filter(|resource| resource.holds == Use::Image);
        let textures =
            images.map(|image| (image.name.clone(), crate::formulas::values::texture(&image.name))).collect();
        let give = Box::new(|random: &mut Random, _: &Setting| random.point());
        Check { linked, setting: Setting::new(parameters), textures, give }
    }

    /// Generator of constrained inputs of a point.
    pub fn given(mut self, give: impl Fn(&mut Random, &Setting) -> [[f64; 4]; 4] + 'static) -> Check {
        self.give = Box::new(give);
        self
    }

    /// A parameter that keeps one value.
    pub fn with(mut self, name: &str, value: &[f64]) -> Check {
        self.setting.fix(name, value);
        self
    }

    /// A check of a scene: its modules, its parameters and its soft region.
    pub fn of_scene(library: &Library, scene: &Scene, text: &str) -> Check {
        let variant = Variant::of(scene, library).unwrap();
        let mut slots = scene.slots(library);
        slots.extend(shader::Slots::clone(&variant.slots));
        let joined = |modules: &[String]| if modules.is_empty() { "-".into() } else { modules.join("+") };
        let slots: Vec<(String, String)> = slots.into_iter().map(|(slot, modules)| (slot, joined(&modules))).collect();
        let slots: Vec<(&str, &str)> = slots.iter().map(|(slot, modules)| (slot.as_str(), modules.as_str())).collect();
        let mut check = Check::new(library, &slots, text);
        let parts = scene.parts.iter().map(|(name, part)| (format!("_{name}"), &part.object));
        for (suffix, object) in [(String::new(), &scene.object)].into_iter().chain(parts) {
            check.setting.fix(&format!("iso_value{suffix}"), &[object.inner_iso.into()]);
            check.setting.fix(&format!("outer_iso_value{suffix}"), &[object.outer_iso.into()]);
        }
        for (name, _, value) in variant.all_parameters() {
            let part = name.strip_prefix("parts.").and_then(|name| name.split_once('.'));
            let name = part.map_or_else(|| name.clone(), |(part, parameter)| format!("{parameter}_{part}"));
            if let ParameterValue::Number(number) = value {
                check.setting.fix(&name, &[f64::from(*number)]);
            }
        }
        check
    }

    pub fn with_texture(mut self, name: &str, texture: Texture) -> Check {
        self.textures.insert(name.into(), texture);
        self
    }

    /// Noise and turbulence that repeat.
    pub fn repeating(mut self) -> Check {
        self.setting.repeats = true;
        self
    }

    /// The largest error over all points, as a part of `tolerance`. An error is relative to 1 and the value.
    pub fn holds(self, tolerance: f64, formula: impl Fn(&At<'_>) -> Vec<f64>) -> f64 {
        self.worst(|at, found| {
            let errors = formula(at).into_iter().zip(found).map(|(expected, found)| {
                assert!(expected.is_finite(), "the formula gives {expected}");
                let error = (found - expected).abs() / (1.0 + expected.abs());
                if error.is_nan() { f64::INFINITY } else { error / tolerance }
            });
            errors.fold(0.0, f64::max)
        })
    }

    /// The largest of what `error` makes of each point and of the eight numbers that the module gives there.
    pub fn worst(self, error: impl Fn(&At<'_>, [f64; 8]) -> f64) -> f64 {
        let mut worst = 0.0f64;
        for largest in self.each(|_, results| results.iter().map(|(at, found)| error(at, *found)).fold(0.0, f64::max)) {
            worst = worst.max(largest);
            if worst > 1.0 {
                break; // it fails whatever follows
            }
        }
        worst
    }

    /// Applies `on` to all points of each setting.
    pub fn each<T>(&self, on: impl Fn(&Setting, &[(At<'_>, [f64; 8])]) -> T) -> impl Iterator<Item = T> {
        let program = Program::read(&self.linked.fragment, &[(0, OCTAVES)]).unwrap_or_else(|error| panic!("{error}"));
        (0..SETTINGS).map(move |index| {
            let textures = &self.textures;
            let setting = self.setting.clone().numbered(index);
            let inputs = self.inputs(&setting);
            let mut random = Random::new(index, "points");
            let points: Vec<[[f64; 4]; 4]> = (0..POINTS).map(|_| (self.give)(&mut random, &setting)).collect();
            let varyings = (0..4).map(|input| (input as u32, points.iter().map(|p| p[input]).collect())).collect();
            let pixel = |i: usize| [(i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5, 0.5, 1.0];
            let lanes = Invocations { fragment_coordinates: (0..POINTS).map(pixel).collect(), varyings };
            let found = program.bind(&inputs).unwrap().run::<f64>(&lanes).unwrap();
            let second = |point: usize| found.get(&1).map_or([0.0; 4], |values| values[point]);
            let results: Vec<_> = points
                .into_iter()
                .enumerate()
                .map(|(index, p)| {
                    let at = At { p, setting: &setting, textures };
                    let ([a, b, c, d], [e, f, g, h]) = (found[&0][index], second(index));
                    (at, [a, b, c, d, e, f, g, h])
                })
                .collect();
            on(&setting, &results)
        })
    }

    /// Most loop iterations of a point.
    pub fn turns(&self) -> u64 {
        let program = Program::read(&self.linked.fragment, &[(0, OCTAVES)]).unwrap_or_else(|error| panic!("{error}"));
        let setting = self.setting.clone().numbered(0);
        let inputs = self.inputs(&setting);
        let mut random = Random::new(0, "points");
        let points: Vec<[[f64; 4]; 4]> = (0..64).map(|_| (self.give)(&mut random, &setting)).collect();
        let varyings = (0..4).map(|input| (input as u32, points.iter().map(|p| p[input]).collect())).collect();
        let lanes = Invocations { fragment_coordinates: vec![[0.5; 4]; points.len()], varyings };
        let bound = program.bind(&inputs).unwrap();
        (0..1000).find(|most| bound.measure_within(&lanes, *most).is_ok()).expect("fewer than 1000 iterations")
    }

    fn inputs(&self, setting: &Setting) -> Inputs {
        let mut inputs = Inputs::default();
        for resource in &self.linked.resources {
            let at = resource.binding;
            match &resource.holds {
                Use::Block(block) => {
                    let values: BTreeMap<&str, Vec<f32>> =
                        block.members.iter().map(|m| (m.name.as_str(), setting.floats(&m.name, m.floats))).collect();
                    inputs.blocks.insert(at, block.fill(|name| values.get(name).map(Vec::as_slice)).unwrap());
                }
                Use::Image => {
                    inputs.images.insert(at, self.textures[&resource.name].clone());
                }
                Use::Sampler if resource.name == "block_sampler" => {
                    inputs.samplers.insert(at, Wrap::Repeat);
                }
                Use::Sampler => {
                    let repeats = resource.name == "repeat_sampler";
                    inputs.samplers.insert(at, if repeats { Wrap::Repeat } else { Wrap::Clamp });
                }
            }
        }
        inputs
    }
}

/// The shipped modules.
pub fn shipped() -> Library {
    shader::shipped()
}

/// Mutation of a module: file, right text, wrong text.
pub type Wrong = (&'static str, &'static str, &'static str);

/// Passes if the check holds for the shipped modules, and fails for each of the wrong ones.
pub fn hold(name: &str, check: fn(&Library) -> f64, wrong: &[Wrong]) {
    let library = shipped();
    let worst = check(&library);
    println!("{name}: largest error {worst:.1e} of what is allowed");
    assert!(worst <= 1.0, "{name}: an error of {worst:.2e} times what is allowed");
    for (file, from, to) in wrong {
        let text = library.source(file).unwrap_or_else(|| panic!("{name}: there is no glsl/{file}"));
        assert!(text.contains(from), "{name}: `{from}` is not in glsl/{file}");
        let other = text.replacen(from, to, 1);
        let sources = library.sources().map(|(path, text)| (path.to_string(), text.to_string()));
        let wrong = Library::new(sources.chain([(file.to_string(), other)]));
        let worst = check(&wrong);
        assert!(worst > 1.0, "{name} holds even if glsl/{file} has `{to}` in place of `{from}`: {worst:.1e}");
    }
}

/// A test for each row: its name, its check, and what makes a file wrong. `ROWS` lists the files.
#[macro_export]
macro_rules! rows {
    ($($name:ident = $check:expr, $($file:literal: $from:literal => $to:literal),+;)+) => {
        /// The files that these rows make wrong.
        pub const ROWS: &[&str] = &[$($($file),+),+];
        $(
            #[test]
            fn $name() {
                $crate::formulas::harness::hold(stringify!($name), $check, &[$(($file, $from, $to)),+]);
            }
        )+
    };
}
