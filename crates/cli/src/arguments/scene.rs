//! Arguments that change a scene.

use super::flags::Flags;
use super::modules::{module, show, show_plane};
use clap::{Args, ValueEnum};
use hypertexture::output::{self, OutputError};
use hypertexture::render::settle_lengths;
use hypertexture::scene::{self, Color, FieldId, Length, ParameterValue, Pass, Reach, Scene, SceneError};
use hypertexture::shader::declare::hex_color;
use hypertexture::shape::BUILT_IN;
use hypertexture_measure::metric::Metric;
use hypertexture_support::words::nearest;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Arguments of the object.
pub(crate) type ObjectFlags = Flags<true>;

/// A debug view.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DebugView {
    /// Normals as colors (MJ Fig. 3a).
    Normals,
    /// Texture coordinates as colors (MJ Fig. 3b).
    TexCoord,
    /// The soft region around the lit object (MJ Fig. 4).
    SoftRegion,
    /// The stack of slices from the side (MJ Fig. 1).
    SliceStack,
    /// A plane of noise as grey, z = plane_z (MJ Fig. 5a); best on a cube.
    Noise,
    /// The gradient of noise on that plane, as colors (MJ Fig. 5b).
    NoiseGradient,
}

/// Arguments of the scene; each overrides it.
#[derive(Args, Clone, Default)]
pub(crate) struct SceneArguments {
    /// The effect; `hypertexture effects` lists them.
    #[arg(long, value_name = "NAME")]
    pub effect: Option<String>,
    /// A debug view.
    #[arg(long, value_enum, hide_short_help = true)]
    pub debug_view: Option<DebugView>,
    /// A parameter of the effect, or any field of a scene file.
    ///
    /// Examples: fineness=60, hair_length=3mm, light.color=#ffe0c0, and parts.OBJECT.PARAMETER=VALUE for an additional
    /// object. May be given again.
    #[arg(long = "set", value_name = "PARAMETER=VALUE")]
    pub parameters: Vec<String>,
    /// The density modulation functions, applied in this order.
    ///
    /// Names, or custom GLSL files, such as fur+my_waves.glsl.
    #[arg(long, value_name = "NAMES")]
    pub dmf: Option<String>,
    /// The module of a slot, such as noise=procedural or surface=my_marble.glsl; may be given again.
    #[arg(long = "module", value_name = "SLOT=NAME", hide_short_help = true)]
    pub modules: Vec<String>,
    /// Degrees around the object and above the horizon, and how close.
    #[arg(long, value_parser = numbers, value_name = "DEG,DEG[,ZOOM]", allow_hyphen_values = true)]
    pub camera: Option<Numbers>,
    /// Let a scene file or a picture name files that are neither below its folder nor below the current one.
    #[arg(long, hide_short_help = true)]
    pub outside: bool,
    /// Settings with a flag.
    #[command(flatten)]
    pub settings: Flags<false>,
}

/// The scene of an input and of arguments.
pub(crate) struct SceneInput {
    /// The scene with the arguments.
    pub(crate) scene: Scene,
    /// The one before them: the preset, the preset nearest to a file, or the scene of a picture.
    pub(crate) base: Scene,
    /// Whether a flag, `--set`, a scene file or the scene of a picture sets the number of rays of a pixel.
    pub(crate) sets_rays_of_a_pixel: bool,
}

/// Settings of the number of rays of a pixel.
const RAYS_OF_A_PIXEL: [&str; 2] = ["quality.supersampling", "quality.msaa"];
/// Default supersampling of final pictures.
const SMOOTH: u32 = 4;

impl SceneInput {
    /// Antialiases a final picture, unless the number of rays of a pixel is set.
    pub(crate) fn smooth(mut self) -> SceneInput {
        if !self.sets_rays_of_a_pixel {
            [&mut self.scene, &mut self.base].into_iter().for_each(smooth);
        }
        self
    }

    /// The scene at its time.
    pub(crate) fn still(self) -> Result<SceneInput, SceneError> {
        Ok(SceneInput { scene: self.scene.moment()?.into_owned(), ..self })
    }
}

/// Antialiases a final picture, unless its scene says how many rays a pixel has.
pub(crate) fn smooth(scene: &mut Scene) {
    if (scene.quality.supersampling, scene.quality.msaa) == (1, 1) {
        scene.quality.supersampling = SMOOTH;
    }
}

/// Comma-separated numbers.
#[derive(Clone)]
pub struct Numbers(Vec<f32>);

fn numbers(text: &str) -> Result<Numbers, String> {
    let parsed: Result<Vec<f32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    parsed.map(Numbers).map_err(|_| "write numbers with commas between them".into())
}

pub(crate) fn metric(text: &str) -> Result<Metric, String> {
    let found = Metric::ALL.into_iter().find(|(name, _)| *name == text);
    found.map(|(_, metric)| metric).ok_or_else(|| {
        let names: Vec<&str> = Metric::ALL.iter().map(|(name, _)| *name).collect();
        format!("write one of {}", names.join(", "))
    })
}

pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    parsed.ok_or_else(|| "write width x height in pixels, such as 640x480".into())
}

impl SceneArguments {
    /// The scene of an input at its time.
    pub fn scene(&self, input: &str, object: &ObjectFlags) -> Result<Scene, Box<dyn Error>> {
        Ok(self.scene_and_base(input, object)?.scene.moment()?.into_owned())
    }

    /// Scene of an input with the arguments applied: a scene file, the scene of a picture, an example scene, or the preset
    /// of the effect.
    pub fn scene_and_base(&self, input: &str, object: &ObjectFlags) -> Result<SceneInput, Box<dyn Error>> {
        let (mut scene, in_file) = self.start(input)?;
        let is_file = Path::new(input).extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
        let mut base = match (is_file, &self.effect) {
            (true, Some(effect)) => scene::preset(effect)?,
            (true, None) => scene::nearest_preset(&scene),
            _ => scene.clone(),
        };
        self.apply_look(&mut base);
        object.apply(&mut scene)?;
        self.apply(&mut scene)?;
        settle_lengths(&mut scene)?;
        let set = |text: &String, name: &str| text.split_once('=').is_some_and(|(own, _)| own.trim() == name);
        let is_set = |name: &str| self.settings.has(name) || self.parameters.iter().any(|text| set(text, name));
        let sets_rays_of_a_pixel = in_file || RAYS_OF_A_PIXEL.into_iter().any(is_set);
        Ok(SceneInput { scene, base, sets_rays_of_a_pixel })
    }

    /// The scene of an input, and whether the input sets the number of rays of a pixel.
    fn start(&self, input: &str) -> Result<(Scene, bool), Box<dyn Error>> {
        let path = Path::new(input);
        let ends = |ends: &[&str]| path.extension().is_some_and(|end| ends.iter().any(|e| end.eq_ignore_ascii_case(e)));
        let (is_file, is_picture) = (ends(&["toml"]), ends(&["png", "exr"]));
        // As for built-in objects, the name wins: `./fire_ball` is a file or a folder.
        let is_example = scene::names().any(|name| name == input);
        if is_example && path.is_file() {
            log::warn!("`{input}` is the example scene; `./{input}` is the file");
        }
        let reach = reach(self.outside);
        let load = || -> Result<(Scene, bool), Box<dyn Error>> {
            Ok(match (is_picture, is_example) {
                (true, _) => (scene_of_picture(path, reach)?, true),
                (_, true) => (scene::preset(input)?, false),
                _ => {
                    let (scene, given) = scene::load_given(path, reach)?;
                    let is_given = |name: &str| FieldId::named(name).is_some_and(|field| given.contains(&field));
                    (scene, RAYS_OF_A_PIXEL.into_iter().any(is_given))
                }
            })
        };
        Ok(match (is_file || is_picture || is_example, &self.effect) {
            (true, None) => load()?,
            (true, Some(effect)) => {
                let (file, sets_rays) = load()?;
                let preset = scene::preset(effect)?;
                let scene = Scene {
                    object: file.object,
                    camera: file.camera,
                    image: file.image,
                    light: file.light,
                    quality: file.quality,
                    groom: file.groom,
                    ..preset
                };
                (scene, sets_rays)
            }
            (false, effect) => {
                if let Some(near) = near_example(input) {
                    return Err(format!("no object, scene or file is called `{input}`; did you mean `{near}`?").into());
                }
                let mut scene = scene::preset(effect.as_deref().unwrap_or("lit"))?;
                scene.replace_object(input);
                (scene, false)
            }
        })
    }

    fn apply(&self, scene: &mut Scene) -> Result<(), SceneError> {
        self.apply_effect(scene)?;
        let (fields, parameters): (Vec<&String>, Vec<&String>) = self
            .parameters
            .iter()
            .partition(|text| text.split_once('=').is_some_and(|(name, _)| is_field(name.trim())));
        // A scene may leave a module out; then its parameters go with it.
        let chooses_modules = fields.iter().any(|text| text.trim_start().starts_with("effect."));
        let was_good = chooses_modules && scene.library().is_ok_and(|library| scene.check(&library).is_ok());
        for text in fields {
            let (field, value) = text.split_once('=').unwrap_or((text, ""));
            scene.set_field(field.trim(), value.trim())?;
        }
        if was_good {
            scene.drop_foreign_parameters(&scene.library()?)?;
        }
        for text in parameters {
            if let Some((name, value)) = text.split_once('=').filter(|(_, value)| Length::parse(value).is_some()) {
                scene.set_field(&field_of_parameter(name.trim()), value.trim())?;
                continue;
            }
            let (name, value) = parameter(text)?;
            let further = name.strip_prefix("parts.").and_then(|rest| rest.split_once('.'));
            let (parameters, name) = match further {
                None => (&mut scene.parameters, name),
                Some((part, parameter)) => {
                    let known: Vec<String> = scene.parts.keys().cloned().collect();
                    let known: Vec<&str> = known.iter().map(String::as_str).collect();
                    let found = scene.parts.get_mut(part);
                    let part = found.ok_or_else(|| SceneError::unknown("additional object", part, &known))?;
                    (&mut part.parameters, parameter.to_string())
                }
            };
            parameters.insert(name, value);
            scene
                .lengths
                .remove(&field_of_parameter(text.split('=').next().unwrap_or_default().trim()).replace('.', "/"));
        }
        let camera = &mut scene.camera;
        match self.camera.as_ref().map(|numbers| numbers.0.as_slice()) {
            None => {}
            Some(&[azimuth, elevation]) => (camera.azimuth, camera.elevation) = (azimuth, elevation),
            Some(&[azimuth, elevation, zoom]) => {
                (camera.azimuth, camera.elevation, camera.zoom) = (azimuth, elevation, zoom);
            }
            Some(other) => {
                return Err(SceneError::Value {
                    field: "--camera".into(),
                    value: other.iter().map(f32::to_string).collect::<Vec<_>>().join(","),
                    limit: "write 2 or 3 numbers: azimuth,elevation[,zoom]".into(),
                });
            }
        }
        self.settings.apply(scene)
    }

    fn apply_look(&self, scene: &mut Scene) {
        match self.debug_view {
            None => {}
            Some(DebugView::Normals) => show(scene, "surface", "normals"),
            Some(DebugView::TexCoord) => show(scene, "surface", "tex_coord"),
            Some(DebugView::SoftRegion) => {
                show(scene, "soft", "lit");
                scene.effect.softness = "linear".into();
                scene.effect.medium = "soft_region".into();
                scene.effect.opacity_rate = 4.0;
            }
            Some(DebugView::SliceStack) => {
                show(scene, "stack", "lit");
                scene.camera.slice_stack = true;
                (scene.quality.pass, scene.quality.samples) = (Pass::Slices, 24);
            }
            Some(DebugView::Noise) => show_plane(scene, "noise"),
            Some(DebugView::NoiseGradient) => show_plane(scene, "noise_gradient"),
        }
    }

    fn apply_effect(&self, scene: &mut Scene) -> Result<(), SceneError> {
        self.apply_look(scene);
        let dmf = self.dmf.as_ref().map(|names| format!("dmf={names}"));
        if self.modules.is_empty() && dmf.is_none() {
            return Ok(());
        }
        // Faults of the given scene are reported before modules and their parameters are removed.
        scene.check(&scene.library()?)?;
        let names_dmf = |text: &&String| {
            text.split_once('=').is_some_and(|(slot, names)| slot.trim() == "dmf" && !names.is_empty())
        };
        if dmf.iter().chain(&self.modules).any(|text| names_dmf(&text)) {
            scene.effect.soften(); // unless the line says otherwise
        }
        for text in dmf.iter().chain(&self.modules) {
            module(text, scene)?;
        }
        let library = scene.library()?;
        scene.drop_foreign_parameters(&library)
    }
}

/// Files that a command reads: the input and those of the scene.
pub(crate) fn files_read(input: &str, scene: &Scene) -> Vec<PathBuf> {
    let is_name = scene::names().any(|name| name == input);
    scene.files().map(|(_, file)| file).chain((!is_name).then_some(input)).map(PathBuf::from).collect()
}

/// Example scene with a similar name.
fn near_example(input: &str) -> Option<&str> {
    let path = Path::new(input);
    let is_known =
        BUILT_IN.contains(&input) || path.exists() || path.extension().is_some() || input.contains(['/', '\\']);
    let known: Vec<&str> = BUILT_IN.iter().copied().chain(scene::names()).collect();
    // The error of an object lists the known ones.
    nearest(input, &known).filter(|near| !is_known && !BUILT_IN.contains(near))
}

/// Rule for files that a scene names, by the flag.
pub(crate) fn reach(outside: bool) -> Reach {
    if outside { Reach::Anywhere } else { Reach::Beside }
}

/// Scene stored in a picture.
fn scene_of_picture(path: &Path, reach: Reach) -> Result<Scene, OutputError> {
    let provenance = output::read_provenance(path)?;
    let of = |source| OutputError::Provenance { path: path.display().to_string(), source };
    let scene = provenance.scene(path, reach).map_err(of)?;
    if let Err(changed) = provenance.check_inputs(path, reach) {
        log::warn!("{}", of(changed));
    }
    Ok(scene)
}

/// Whether `--set` names a field of the scene: `table.field`, or one of the three top-level fields.
fn is_field(name: &str) -> bool {
    let is_parameter_of_part = name.starts_with("parts.") && name.split('.').count() == 3;
    (name.contains('.') && !is_parameter_of_part) || ["about", "combine", "boolean"].contains(&name)
}

/// The field of a parameter: `amplitude`, or `parts.b.amplitude` of an additional object.
fn field_of_parameter(name: &str) -> String {
    match name.strip_prefix("parts.").and_then(|rest| rest.split_once('.')) {
        Some((part, parameter)) => format!("parts.{part}.parameters.{parameter}"),
        None => format!("parameters.{name}"),
    }
}

fn parameter(text: &str) -> Result<(String, ParameterValue), SceneError> {
    let wrong = || SceneError::Value {
        field: "--set".into(),
        value: text.into(),
        limit: "write PARAMETER=NUMBER or PARAMETER=#rrggbb, such as fineness=60".into(),
    };
    let (name, value) = text.split_once('=').ok_or_else(wrong)?;
    let value = match value.trim().parse() {
        Ok(number) => ParameterValue::Number(number),
        Err(_) => ParameterValue::Color(Color(hex_color(value.trim()).ok_or_else(wrong)?)),
    };
    Ok((name.trim().into(), value))
}
