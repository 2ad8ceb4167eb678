//! The command line, and how it goes over a scene.

use super::compare::Compare;
use super::modules::{module, show};
use super::sequence::{Motion, ShardChoice, shard};
use clap::{Args, Parser, Subcommand, ValueEnum};
use hypertexture::glsl::library::hex_color;
use hypertexture::output::{self, Depth, OutputError};
use hypertexture::pick::Metric;
use hypertexture::scene::{self, Color, KnobValue, Object, Scene, SceneError};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Texture and hypertexture volumetric objects: fur, fire, melting and more around a mesh, a scan or a formula.
#[derive(Parser)]
#[command(version, max_term_width = 100)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Part of the name of the Vulkan device to use.
    #[arg(long, global = true, env = "HYPERTEXTURE_DEVICE", value_name = "NAME")]
    pub device: Option<String>,
    /// Say nothing but errors.
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

/// What the program does.
#[derive(Subcommand)]
pub enum Command {
    /// Render a picture.
    Render(Box<Render>),
    /// Show a window, in which the mouse turns the scene and panels change it.
    #[cfg(feature = "view")]
    View(Box<View>),
    /// Join the shards of a picture, as `render --shard` writes them.
    Merge(Merge),
    /// Compute the distance field of an object and write it as NRRD.
    Field(Field),
    /// Render every figure, or the six effects on one object, with a page that explains them.
    Gallery(Gallery),
    /// Measure error against run time: strategies, samples, blocks, formats and rules, with a report.
    Compare(Box<Compare>),
    /// List the effects and their knobs.
    Effects,
    /// Hold the device against closed forms in both passes, or a picture against the scene in it.
    Verify(Verify),
    /// Say which device was found, what is missing, and test what the renderer relies on.
    Doctor,
    /// Compile the job on standard input: what the window runs a user's GLSL through.
    #[cfg(feature = "view")]
    #[command(hide = true)]
    Compile(Compile),
    /// Render a few rays of the scene on standard input: what the window tries a user's GLSL with.
    #[cfg(feature = "view")]
    #[command(hide = true)]
    Rays(Rays),
}

/// Arguments of `render`.
#[derive(Args)]
pub struct Render {
    /// A built-in object, a mesh, a scalar volume, a distance field, a scene file (.toml), a figure such as fire_ball, or
    /// a picture that this program has written: its scene.
    pub input: String,
    /// Where the picture goes: .png or .exr.
    #[arg(long, short, default_value = "out.png", value_name = "FILE")]
    pub output: PathBuf,
    /// Bits of each channel of a PNG.
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    pub depth: String,
    /// Write the scene in use, complete with defaults.
    #[arg(long, value_name = "FILE")]
    pub save_scene: Option<PathBuf>,
    /// Say what the picture will cost, from small ones, and write none.
    #[arg(long, conflicts_with_all = ["frames", "shard"])]
    pub predict: bool,
    /// Draw it in the cheapest way whose error is below this, such as 1e-3; the scene says what is drawn, and no longer how.
    #[arg(long, value_name = "ERROR", conflicts_with = "shard")]
    pub max_error: Option<f64>,
    /// How that error is measured: rmse, max, p999, opacity.
    #[arg(long, default_value = "rmse", value_parser = metric, requires = "max_error")]
    pub metric: Metric,
    /// Render part K, from 0 to N - 1, of a picture or of the frames; without a value, the part that Slurm or
    /// Kubernetes gives to this process.
    #[arg(long, value_name = "K/N", num_args = 0..=1, default_missing_value = "auto", value_parser = shard)]
    pub shard: Option<ShardChoice>,
    /// Many frames.
    #[command(flatten)]
    pub motion: Motion,
    /// The object.
    #[command(flatten)]
    pub object: ObjectArguments,
    /// What the picture shows.
    #[command(flatten)]
    pub look: Look,
}

impl Render {
    /// Bits of each channel of a PNG.
    pub fn depth(&self) -> Depth {
        if self.depth == "16" { Depth::Sixteen } else { Depth::Eight }
    }
}

/// Arguments of `view`.
#[cfg(feature = "view")]
#[derive(Args)]
pub struct View {
    /// A built-in object, a mesh, a scalar volume, a distance field, a scene file (.toml), or a figure such as fire_ball.
    #[arg(default_value = "furry_donut")]
    pub input: String,
    /// Refine a picture that stands still until its root mean square error is about this [default: 0.001].
    #[arg(long, value_name = "RMSE", value_parser = error)]
    pub max_error: Option<f64>,
    /// Let time run from the beginning.
    #[arg(long)]
    pub play: bool,
    /// Width and height of the window, in points.
    #[arg(long, default_value = "1280x800", value_parser = size, value_name = "WxH")]
    pub window: [u32; 2],
    /// Draw so many frames after the first picture, then end.
    #[arg(long, value_name = "NUMBER")]
    pub frames: Option<u32>,
    /// Write the picture that `render` makes, after those frames or when the picture has converged, then end.
    #[arg(long, value_name = "FILE")]
    pub screenshot: Option<PathBuf>,
    /// Do what this file says.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "screenshot"], hide = true)]
    pub script: Option<PathBuf>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectArguments,
    /// What the picture shows.
    #[command(flatten)]
    pub look: Look,
}

#[cfg(feature = "view")]
fn error(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|error| (1e-7..=1.0).contains(error));
    parsed.ok_or_else(|| "write a number from 1e-7 to 1; a code of 8 bits is 0.004".into())
}

/// Arguments of `merge`.
#[derive(Args)]
pub struct Merge {
    /// Where the picture goes: .png or .exr.
    pub output: PathBuf,
    /// All shards of the picture, in any order.
    #[arg(required = true, value_name = "SHARD")]
    pub shards: Vec<PathBuf>,
}

/// Arguments of `verify`.
#[derive(Args)]
pub struct Verify {
    /// A picture that this program has written: .png or .exr; without one, the device is verified.
    pub image: Option<PathBuf>,
    /// How many pixels of the picture are held against the truth.
    #[arg(long, default_value_t = 1000, requires = "image", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub pixels: u32,
    /// Which pixels.
    #[arg(long, default_value_t = 0, requires = "image")]
    pub seed: u64,
    /// The root mean square error that is allowed; without it, what the codes of the file and its step explain.
    #[arg(long, requires = "image", value_parser = bound)]
    pub bound: Option<f64>,
}

fn bound(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|bound| (0.0..=1.0).contains(bound)).ok_or_else(|| "must be from 0 to 1".into())
}

/// Arguments of `compile`: the limits of the process.
#[cfg(feature = "view")]
#[derive(Args)]
pub struct Compile {
    /// Time of the processor, seconds.
    #[arg(long, default_value_t = 10)]
    pub seconds: u64,
    /// Address space, MiB.
    #[arg(long, default_value_t = 1024)]
    pub memory_mib: u64,
}

/// Arguments of `rays`: the limit of the process.
#[cfg(feature = "view")]
#[derive(Args)]
pub struct Rays {
    /// Time of the processor, seconds.
    #[arg(long, default_value_t = 20)]
    pub seconds: u64,
}

/// How an input becomes an object.
#[derive(Args)]
pub struct ObjectArguments {
    /// Iso-value of the surface of a scalar volume; the middle of its range without one.
    #[arg(long, allow_negative_numbers = true)]
    iso: Option<f32>,
    /// The axis of the file that points up: x, y, z, -x, -y, -z.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    up: Option<String>,
    /// Factors by which the object is stretched along x, y and z.
    #[arg(long, value_parser = numbers, value_name = "X,Y,Z")]
    stretch: Option<Numbers>,
    /// The volume holds signed distances, positive outside, although its file does not say so.
    #[arg(long)]
    distance: bool,
    /// Voxels along the longest side of the distance field.
    #[arg(long)]
    resolution: Option<u32>,
    /// How the distance is stored: auto, normals16, normals8, distance16, distance32.
    #[arg(long, value_name = "KIND")]
    source: Option<String>,
}

impl ObjectArguments {
    /// Puts what was given over an object.
    pub fn apply(&self, object: &mut Object) -> Result<(), SceneError> {
        object.iso = self.iso.or(object.iso);
        object.distance |= self.distance;
        put(&mut object.resolution, self.resolution);
        if let Some(Numbers(stretch)) = &self.stretch {
            let wrong = |_| count("--stretch", stretch, "3 numbers: x,y,z");
            object.stretch = stretch.as_slice().try_into().map_err(wrong)?;
        }
        name_into("--up", &self.up, &mut object.up)?;
        name_into("--source", &self.source, &mut object.source)
    }
}

/// Arguments of `field`.
#[derive(Args)]
pub struct Field {
    /// A built-in object, a mesh, a scalar volume or a distance field.
    pub input: String,
    /// Where the field goes: .nrrd.
    #[arg(long, short, default_value = "field.nrrd", value_name = "FILE")]
    pub output: PathBuf,
    /// The object.
    #[command(flatten)]
    pub object: ObjectArguments,
    /// How far the field reaches beyond the object; 1 is half of its longest side.
    #[arg(long, default_value_t = 0.25, allow_negative_numbers = true)]
    pub margin: f32,
}

/// Arguments of `gallery`.
#[derive(Args)]
pub struct Gallery {
    /// The object of the six effects; without one, every figure has its own object.
    pub input: Option<String>,
    /// Where pictures and page go.
    #[arg(long, short, default_value = "out", value_name = "FOLDER")]
    pub output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "512x512", value_parser = size, value_name = "WxH")]
    pub size: [u32; 2],
    /// Samples of a ray through the object; what the figure says without it.
    #[arg(long)]
    pub samples: Option<u32>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectArguments,
}

/// A look that shows how a picture is made.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Debug {
    /// Normals as colors (MJ Fig. 3a).
    Normals,
    /// Texture coordinates as colors (MJ Fig. 3b).
    TexCoord,
    /// The soft region around the lit object (MJ Fig. 4).
    SoftRegion,
    /// The stack of slices from the side (MJ Fig. 1).
    SliceStack,
}

/// What a picture shows: each goes over the scene.
#[derive(Args, Default)]
pub struct Look {
    /// The effect; `hypertexture effects` lists them.
    #[arg(long, value_name = "NAME")]
    pub effect: Option<String>,
    /// A look that shows how the picture is made.
    #[arg(long, value_enum)]
    pub look: Option<Debug>,
    /// A knob of the effect, or as parts.OBJECT.KNOB of a further object; or any field of a scene file, such as
    /// light.color=#ffe0c0; may be given again.
    #[arg(long = "set", value_name = "KNOB=VALUE")]
    pub knobs: Vec<String>,
    /// The density modulation functions, applied in this order: names, or GLSL files of one's own, such as fur+my_waves.glsl.
    #[arg(long, value_name = "NAMES")]
    pub dmf: Option<String>,
    /// The module of a slot, such as noise=procedural or surface=my_marble.glsl; may be given again.
    #[arg(long = "module", value_name = "SLOT=NAME")]
    pub modules: Vec<String>,
    /// Width and height in pixels.
    #[arg(long, value_parser = size, value_name = "WxH")]
    pub size: Option<[u32; 2]>,
    /// How the samples are taken: slices, march.
    #[arg(long)]
    pub pass: Option<String>,
    /// Which samples of a ray are taken: leap, fixed.
    #[arg(long)]
    pub traverse: Option<String>,
    /// Slices through the object, or samples of a ray through it.
    #[arg(long)]
    pub samples: Option<u32>,
    /// What a sample stands for: point, segment (second order at surfaces and in opaque matter).
    #[arg(long)]
    pub rule: Option<String>,
    /// The normal that soft matter is lit by: analytic, central, three.
    #[arg(long, value_name = "MODULE")]
    pub gradient: Option<String>,
    /// Each pixel has its own phase of the steps: noise in place of contours.
    #[arg(long)]
    pub jitter: bool,
    /// Which phases the pixels have.
    #[arg(long, value_name = "NUMBER")]
    pub seed: Option<u32>,
    /// Pictures of which the mean is taken, 1 to 256.
    #[arg(long, value_name = "PICTURES")]
    pub supersampling: Option<u32>,
    /// Format that the slices are blended in: unorm8, float16, float32.
    #[arg(long, value_name = "FORMAT")]
    pub target: Option<String>,
    /// Order of the slices: front_to_back, back_to_front.
    #[arg(long)]
    pub order: Option<String>,
    /// Shape of the slices: polygons, quads.
    #[arg(long)]
    pub proxy: Option<String>,
    /// Samples per pixel: 1, 2, 4, 8.
    #[arg(long)]
    pub msaa: Option<u32>,
    /// Anisotropy of the texture filter, 1 to 16.
    #[arg(long)]
    pub anisotropy: Option<f32>,
    /// Degrees around the object, degrees above the horizon, and how close.
    #[arg(long, value_parser = numbers, value_name = "AZIMUTH,ELEVATION[,ZOOM]", allow_hyphen_values = true)]
    pub camera: Option<Numbers>,
    /// How rays leave the eye: perspective, parallel.
    #[arg(long)]
    pub projection: Option<String>,
    /// Position of the light from the center of the object: right, up, toward the eye.
    #[arg(long, value_parser = numbers, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub light: Option<Numbers>,
    /// Whether matter casts shadows.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    pub shadows: Option<bool>,
    /// Time in seconds.
    #[arg(long, allow_negative_numbers = true)]
    pub time: Option<f32>,
    /// Seconds that the shutter stays open; needs --supersampling.
    #[arg(long)]
    pub shutter: Option<f32>,
    /// Keeps the points with a x + b y + c z <= d; the object spans -1 to 1.
    #[arg(long, value_parser = numbers, value_name = "A,B,C,D", allow_hyphen_values = true)]
    pub clip: Option<Numbers>,
    /// Color behind the object, #rrggbb, or `none` for transparent.
    #[arg(long, value_name = "COLOR")]
    pub background: Option<String>,
}

/// Comma-separated numbers.
#[derive(Clone)]
pub struct Numbers(Vec<f32>);

fn numbers(text: &str) -> Result<Numbers, String> {
    let parsed: Result<Vec<f32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    parsed.map(Numbers).map_err(|_| "write numbers with commas between them".into())
}

fn metric(text: &str) -> Result<Metric, String> {
    let found = Metric::ALL.into_iter().find(|(name, _)| *name == text);
    found.map(|(_, metric)| metric).ok_or_else(|| "write rmse, max, p999 or opacity".into())
}

pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    parsed.ok_or_else(|| "write width x height in pixels, such as 640x480".into())
}

impl Look {
    /// The scene of an input: its file, that of a picture, the figure of that name, or the preset of the effect, with the
    /// arguments over it.
    pub fn scene(&self, input: &str, object: &ObjectArguments) -> Result<Scene, Box<dyn Error>> {
        let path = Path::new(input);
        let ends = |ends: &[&str]| path.extension().is_some_and(|end| ends.iter().any(|e| end.eq_ignore_ascii_case(e)));
        let (is_file, is_picture) = (ends(&["toml"]), ends(&["png", "exr"]));
        let is_figure = !path.exists() && scene::names().any(|name| name == input);
        let load = || -> Result<Scene, Box<dyn Error>> {
            Ok(match (is_picture, is_figure) {
                (true, _) => scene_of_picture(path)?,
                (_, true) => scene::preset(input)?,
                _ => scene::load(path)?,
            })
        };
        let mut scene = match (is_file || is_picture || is_figure, &self.effect) {
            (true, None) => load()?,
            (true, Some(effect)) => {
                let file = load()?;
                let preset = scene::preset(effect)?;
                Scene {
                    object: file.object,
                    camera: file.camera,
                    image: file.image,
                    light: file.light,
                    quality: file.quality,
                    ..preset
                }
            }
            (false, effect) => {
                let mut scene = scene::preset(effect.as_deref().unwrap_or("lit"))?;
                scene.object.input = input.into();
                scene
            }
        };
        object.apply(&mut scene.object)?;
        self.apply(&mut scene)?;
        Ok(scene)
    }

    fn apply(&self, scene: &mut Scene) -> Result<(), SceneError> {
        self.apply_effect(scene)?;
        for text in &self.knobs {
            if let Some((field, value)) = text.split_once('=').filter(|(name, _)| is_field(name.trim())) {
                scene.set_field(field.trim(), value.trim())?;
                continue;
            }
            let (name, value) = knob(text)?;
            let further = name.strip_prefix("parts.").and_then(|rest| rest.split_once('.'));
            let (knobs, name) = match further {
                None => (&mut scene.knobs, name),
                Some((part, knob)) => {
                    let known: Vec<String> = scene.parts.keys().cloned().collect();
                    let known: Vec<&str> = known.iter().map(String::as_str).collect();
                    let found = scene.parts.get_mut(part);
                    let part = found.ok_or_else(|| SceneError::unknown("further object", part, &known))?;
                    (&mut part.knobs, knob.to_string())
                }
            };
            knobs.insert(name, value);
        }
        put(&mut scene.effect.gradient, self.gradient.clone());
        let quality = &mut scene.quality;
        quality.jitter |= self.jitter;
        put(&mut quality.seed, self.seed);
        put(&mut quality.supersampling, self.supersampling);
        name_into("--rule", &self.rule, &mut quality.rule)?;
        put(&mut quality.samples, self.samples);
        put(&mut quality.msaa, self.msaa);
        put(&mut quality.anisotropy, self.anisotropy);
        name_into("--pass", &self.pass, &mut quality.pass)?;
        name_into("--traverse", &self.traverse, &mut quality.traverse)?;
        name_into("--target", &self.target, &mut quality.target)?;
        name_into("--order", &self.order, &mut quality.order)?;
        name_into("--proxy", &self.proxy, &mut quality.proxy)?;
        put(&mut scene.image.size, self.size);
        let camera = &mut scene.camera;
        name_into("--projection", &self.projection, &mut camera.projection)?;
        put(&mut camera.time, self.time);
        put(&mut camera.shutter, self.shutter);
        match self.camera.as_ref().map(|numbers| numbers.0.as_slice()) {
            None => {}
            Some(&[azimuth, elevation]) => (camera.azimuth, camera.elevation) = (azimuth, elevation),
            Some(&[azimuth, elevation, zoom]) => {
                (camera.azimuth, camera.elevation, camera.zoom) = (azimuth, elevation, zoom);
            }
            Some(other) => return Err(count("--camera", other, "2 or 3 numbers: azimuth,elevation[,zoom]")),
        }
        if let Some(Numbers(light)) = &self.light {
            let wrong = |_| count("--light", light, "3 numbers: x,y,z");
            scene.light.position = light.as_slice().try_into().map_err(wrong)?;
        }
        put(&mut scene.light.shadows, self.shadows);
        if let Some(Numbers(clip)) = &self.clip {
            let wrong = |_| count("--clip", clip, "4 numbers: a,b,c,d");
            camera.clip = Some(clip.as_slice().try_into().map_err(wrong)?);
        }
        match self.background.as_deref() {
            None => {}
            Some("none") => scene.image.background = None,
            Some(text) => scene.image.background = Some(color("--background", text)?),
        }
        Ok(())
    }

    fn apply_effect(&self, scene: &mut Scene) -> Result<(), SceneError> {
        match self.look {
            None => {}
            Some(Debug::Normals) => show(scene, "surface", "normals"),
            Some(Debug::TexCoord) => show(scene, "surface", "tex_coord"),
            Some(Debug::SoftRegion) => {
                show(scene, "soft", "lit");
                scene.effect.softness = "linear".into();
                scene.effect.medium = "soft_region".into();
                scene.effect.opacity_rate = 4.0;
            }
            Some(Debug::SliceStack) => {
                show(scene, "stack", "lit");
                scene.camera.slice_stack = true;
                scene.quality.samples = 24;
            }
        }
        let dmf = self.dmf.as_ref().map(|names| format!("dmf={names}"));
        if self.modules.is_empty() && dmf.is_none() {
            return Ok(());
        }
        // What is wrong with the scene as it came is said before modules go, and knobs with them.
        scene.check(&scene.library()?)?;
        if dmf.is_some() {
            // A hard object has no density to modulate; it becomes soft, unless the line says otherwise.
            let effect = &mut scene.effect;
            for (slot, hard, soft) in
                [(&mut effect.softness, "hard", "linear"), (&mut effect.classify, "surface", "soft")]
            {
                if slot == hard {
                    *slot = soft.into();
                }
            }
        }
        for text in dmf.iter().chain(&self.modules) {
            module(text, scene)?;
        }
        let library = scene.library()?;
        scene.drop_foreign_knobs(&library)
    }
}

/// The scene that a picture says it shows.
fn scene_of_picture(path: &Path) -> Result<Scene, OutputError> {
    let provenance = output::read_provenance(path)?;
    let of = |source| OutputError::Provenance { path: path.display().to_string(), source };
    let scene = provenance.scene(path).map_err(of)?;
    if let Err(changed) = provenance.check_inputs(path) {
        log::warn!("{}", of(changed));
    }
    Ok(scene)
}

fn put<T>(field: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *field = value;
    }
}

/// A name as scene files spell it.
fn name_into<T: serde::de::DeserializeOwned>(
    flag: &str,
    text: &Option<String>,
    field: &mut T,
) -> Result<(), SceneError> {
    let Some(text) = text else { return Ok(()) };
    let value = toml::Value::String(text.clone());
    *field = value.try_into().map_err(|error: toml::de::Error| SceneError::Value {
        field: flag.into(),
        value: text.clone(),
        limit: error.message().replace('\n', " "),
    })?;
    Ok(())
}

/// Whether `--set` means a field of the scene: one in a table, or one of the three that are in none.
fn is_field(name: &str) -> bool {
    let is_knob_of_part = name.starts_with("parts.") && name.split('.').count() == 3;
    (name.contains('.') && !is_knob_of_part) || ["about", "combine", "boolean"].contains(&name)
}

fn knob(text: &str) -> Result<(String, KnobValue), SceneError> {
    let wrong = || SceneError::Value {
        field: "--set".into(),
        value: text.into(),
        limit: "write KNOB=NUMBER or KNOB=#rrggbb, such as fineness=60".into(),
    };
    let (name, value) = text.split_once('=').ok_or_else(wrong)?;
    let value = match value.trim().parse() {
        Ok(number) => KnobValue::Number(number),
        Err(_) => KnobValue::Color(Color(hex_color(value.trim()).ok_or_else(wrong)?)),
    };
    Ok((name.trim().into(), value))
}

fn color(flag: &str, text: &str) -> Result<Color, SceneError> {
    let limit = "write #rrggbb, such as #203040, or none".to_string();
    let wrong = || SceneError::Value { field: flag.into(), value: text.into(), limit };
    hex_color(text).map(Color).ok_or_else(wrong)
}

fn count(flag: &str, found: &[f32], limit: &str) -> SceneError {
    SceneError::Value { field: flag.into(), value: format!("{} numbers", found.len()), limit: limit.into() }
}
