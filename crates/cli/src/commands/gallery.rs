//! The gallery: every example scene on its own object, or the effects of MJ Fig. 7 on one, and a page that explains them.

use super::export::live;
use crate::arguments::{ObjectFlags, size, smooth};
use crate::session::{Failed, check_folder, start};
use crate::terminal::{absolute, announced, say};
use clap::Args;
use hypertexture::field::Progress;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::output::{Depth, OutputError, Provenance, encode_png};
use hypertexture::render::variant::{Variant, VariantError};
use hypertexture::render::{Frame, RenderError, Subject};
use hypertexture::scene::{Color, EFFECTS, Object, ParameterValue, Scene, SceneError, names, preset, to_text};
use hypertexture::shader::{self, Library, ParameterKind};
use hypertexture_measure::worker::{Load, Painter, Start, Worker};
use hypertexture_support::write_whole;
use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `gallery`.
#[derive(Args)]
pub(crate) struct GalleryArguments {
    /// The object of the six effects; without one, every example scene has its own object.
    pub input: Option<String>,
    /// Output folder.
    #[arg(long, short, default_value = "out", value_name = "FOLDER")]
    pub output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "320x320", value_parser = size, value_name = "WxH")]
    pub size: [u32; 2],
    /// Samples of a ray through the object [default: the scene's].
    #[arg(long)]
    pub samples: Option<u32>,
    /// Write a live page of each scene too, behind its picture.
    #[arg(long)]
    pub web: bool,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
}

/// Voxels along the longest side of the field. Lower frays thin parts, such as the lip of the teapot.
const RESOLUTION: u32 = 256;

/// Background of the page, for pictures without one.
const BACKGROUND: Color = Color([24, 26, 31]);

/// Renders the scenes and writes the page.
pub(crate) fn run(command: &GalleryArguments, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let library = shader::shipped();
    let gpu = Gpu::new(options)?;
    let mut scenes = match &command.input {
        Some(input) => effects(input)?,
        None => examples()?,
    };
    for (_, scene) in &mut scenes {
        scene.image.size = command.size;
        scene.quality.samples = command.samples.unwrap_or(scene.quality.samples);
        smooth(scene);
        command.object.apply(scene)?;
    }
    // Checked before the first picture, which creates the folder.
    check_folder(&command.output)?;
    let (began, start) = (Instant::now(), start(options)?);
    let (library, output) = (&library, &Output { folder: &command.output, web: command.web });
    let Gallery { page, failures } =
        announced(quiet, "gallery", |progress| write(&gpu, library, &scenes, &start, output, progress))?;
    if !quiet {
        say(&format!(
            "rendered {} scenes in {:.1} s on {}\nwrote {}\n",
            scenes.len() - failures.len(),
            began.elapsed().as_secs_f64(),
            gpu.info().name,
            absolute(&page)
        ));
    }
    let count = failures.len();
    failures.into_iter().next().map_or(Ok(()), |(name, reason)| {
        Err(Failed(format!("{count} of {} scenes failed; the first, {name}: {reason}", scenes.len())).into())
    })
}

/// The six effects on an object, by name.
///
/// # Errors
/// A shipped preset that cannot be read, which its test excludes.
pub fn effects(input: &str) -> Result<Vec<(String, Scene)>, SceneError> {
    let mut scenes = EFFECTS.iter().map(|name| example(name)).collect::<Result<Vec<_>, _>>()?;
    scenes.iter_mut().for_each(|(_, scene)| scene.replace_object(input));
    Ok(scenes)
}

/// Every preset on its own object, by name.
///
/// # Errors
/// As [`effects`].
pub fn examples() -> Result<Vec<(String, Scene)>, SceneError> {
    names().map(example).collect()
}

/// A preset on the page.
fn example(name: &str) -> Result<(String, Scene), SceneError> {
    let mut scene = preset(name)?;
    scene.object.resolution = RESOLUTION;
    scene.image.background = scene.image.background.or(Some(BACKGROUND));
    Ok((name.to_string(), scene))
}

/// Result of a gallery.
#[derive(Clone, Debug)]
pub struct Gallery {
    /// The page.
    pub page: PathBuf,
    /// Scenes that crashed the driver, and its message.
    pub failures: Vec<(String, String)>,
}

/// Output of a gallery.
pub struct Output<'a> {
    /// The folder of `index.html` and the pictures.
    pub folder: &'a Path,
    /// Whether to write the page of each scene that can be carried.
    pub web: bool,
}

/// Renders the scenes by workers, and writes their pictures and `index.html`. A scene that crashes the driver is left out.
///
/// # Errors
/// A scene that cannot be drawn, or a file that cannot be written.
pub fn write(
    gpu: &Gpu,
    library: &Library,
    scenes: &[(String, Scene)],
    start: &Start,
    output: &Output<'_>,
    progress: Progress<'_>,
) -> Result<Gallery, Box<dyn Error>> {
    let Output { folder, web } = *output;
    let io = |path: &Path| {
        let path = path.display().to_string();
        move |source| OutputError::Write { path, source }
    };
    let scenes = checked(library, scenes)?;
    let mut objects = objects(&scenes);
    let mut failures = Vec::new();
    let mut groups: [(&str, String); 3] = GROUPS.map(|title| (title, String::new()));
    let share = 1.0 / scenes.len().max(1) as f32;
    for (index, (name, variant)) in scenes.iter().enumerate() {
        let scene = &variant.scene;
        let shared = objects.iter_mut().find(|shared| shared.serves(variant));
        let shared = shared.expect("`objects` holds the object of every scene");
        let frame = match shared.draw(library, scene, start) {
            Ok(frame) => frame,
            Err(RenderError::Ended(reason)) => {
                let title = name.replace('_', " ");
                let text = &mut groups[group(&scene.about)].1;
                writeln!(
                    text,
                    "<figure id=\"{name}\"><figcaption><h3>{title}</h3><p>Failed: {}</p></figcaption></figure>",
                    escape(&reason)
                )
                .expect("writing to a string");
                failures.push((name.clone(), reason));
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        std::fs::create_dir_all(folder).map_err(io(folder))?; // not before an object that cannot be read
        let file = format!("{name}.png");
        let path = folder.join(&file);
        let provenance = Provenance::of(scene, &gpu.info().title(), &frame.measurements);
        let provenance = provenance.map_err(|source| OutputError::Provenance { path: name.clone(), source })?;
        let png = encode_png(&frame, scene.image.background, Depth::Eight, &provenance)?;
        write_whole(&path, &png).map_err(io(&path))?;
        let title = name.replace('_', " ");
        let is_live = web && {
            let subject = Subject::load(scene, library, &|_| ())?;
            live(library, &subject, scene, &title, &png, &folder.join(name))?
        };
        let [link, end] =
            if is_live { [format!("<a href=\"{name}/index.html\">"), "</a>".into()] } else { Default::default() };
        let m = &frame.measurements;
        let input = escape(&scene.object.input);
        let command = escape(&scene.command_line(library));
        write!(
            groups[group(&scene.about)].1,
            "<figure id=\"{name}\">{link}<img src=\"{file}\" width=\"{}\" height=\"{}\" alt=\"{name} on {input}\">{end}\n<figcaption><h3>{}</h3><p>{}</p>\n{}\n\
             <p class=\"cost\">{} samples in depth, {:.0} ms on the device. Modules: <code>{}</code>. Left out: {}.</p>\n\
             <p><code>{command} -o {file}</code></p></figcaption></figure>\n",
            scene.image.size[0], scene.image.size[1], title, escape(&scene.about),
            parameter_table(variant), m.slices, m.gpu_ms, escape(&m.modules),
            if m.left_out.is_empty() { "nothing".into() } else { m.left_out.join(", ") },
        )
        .expect("writing to a string");
        progress((index + 1) as f32 * share);
    }
    let mut figures = String::new();
    for (title, text) in groups.iter().filter(|(_, text)| !text.is_empty()) {
        write!(figures, "<section>\n<h2>{title}</h2>\n{text}</section>\n").expect("writing to a string");
    }
    let info = gpu.info();
    let page = PAGE
        .replace("{count}", &scenes.len().to_string())
        .replace("{device}", &escape(&format!("{} ({})", info.name, info.driver)))
        .replace("{figures}", &figures);
    let path = folder.join("index.html");
    std::fs::create_dir_all(folder).map_err(io(folder))?;
    write_whole(&path, page.as_bytes()).map_err(io(&path))?;
    Ok(Gallery { page: path, failures })
}

/// Headings of the page.
const GROUPS: [&str; 3] = ["Miller and Jones 2005", "Perlin and Hoffert 1989", "and more"];

/// Heading of a scene: the first paper that its description names.
fn group(about: &str) -> usize {
    let place = |title: &&str| about.find(*title);
    let named = (0..2).filter(|&group| place(&GROUPS[group]).is_some());
    named.min_by_key(|&group| place(&GROUPS[group])).unwrap_or(2)
}

/// An object that scenes share, and its worker once started.
struct Shared {
    object: Object,
    /// Margin of the field. It decides where voxels lie, so scenes share a field only with equal margins.
    margin: f32,
    closest: bool,
    /// The scene, if it has several objects: it shares none of them.
    alone: Option<Variant>,
    worker: Option<Worker>,
}

impl Shared {
    fn serves(&self, variant: &Variant) -> bool {
        let scene = &variant.scene;
        match &self.alone {
            Some(alone) => alone == variant,
            None => {
                let same = || self.object.without_look() == scene.object.without_look();
                !scene.has_several() && self.margin == margin(variant) && same()
            }
        }
    }

    /// Draws a picture of the object.
    fn draw(&mut self, library: &Library, scene: &Scene, start: &Start) -> Result<Frame, RenderError> {
        let worker = self.worker.get_or_insert_with(|| {
            let object = Box::new(self.object.clone());
            let load = match &self.alone {
                Some(alone) => Load::Scene(to_text(&alone.scene)),
                None => Load::Object { object, margin: self.margin, closest: self.closest },
            };
            Worker::new(start, library, load)
        });
        Painter::of(worker).render(scene)
    }
}

/// The scenes, checked.
fn checked(library: &Library, scenes: &[(String, Scene)]) -> Result<Vec<(String, Variant)>, VariantError> {
    scenes.iter().map(|(name, scene)| Ok((name.clone(), Variant::of(scene, library)?))).collect()
}

/// Objects of the scenes without duplicates.
fn objects(scenes: &[(String, Variant)]) -> Vec<Shared> {
    let mut objects: Vec<Shared> = Vec::new();
    for (_, variant) in scenes {
        let closest = variant.reads_closest();
        match objects.iter_mut().find(|shared| shared.serves(variant)) {
            Some(shared) => shared.closest |= closest,
            None => objects.push(Shared {
                object: variant.scene.object.clone(),
                margin: margin(variant),
                closest,
                alone: variant.scene.has_several().then(|| variant.clone()),
                worker: None,
            }),
        }
    }
    objects
}

/// Reach of the soft region of a scene, object units.
fn margin(variant: &Variant) -> f32 {
    variant.parameters.outer_iso().unwrap_or(variant.scene.object.outer_iso)
}

fn parameter_table(variant: &Variant) -> String {
    let mut table = String::from("<table>\n");
    for (name, parameter, value) in variant.all_parameters() {
        let value = match value {
            ParameterValue::Number(number) => number.to_string(),
            ParameterValue::Color(color) => String::from(*color),
        };
        let range = match parameter.kind {
            ParameterKind::Number(_, [low, high]) => format!("{low} to {high}"),
            ParameterKind::Color(_) => "color".into(),
        };
        let cells = format!("<td><code>{name}</code><td>{value}<td>{range}<td>{}", escape(&parameter.doc));
        writeln!(table, "<tr>{cells}</tr>").expect("writing to a string");
    }
    table + "</table>"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

const PAGE: &str = include_str!("gallery.html");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_stands_under_the_paper_that_it_names_first() {
        assert_eq!(group("Fur: Perlin and Hoffert 1989, sect. 2.4; Miller and Jones 2005, Fig. 7d."), 1);
        assert_eq!(group("Fur: Miller and Jones 2005, Fig. 7d; Perlin and Hoffert 1989, sect. 2.4."), 0);
        assert_eq!(group("Something else."), 2);
    }

    #[test]
    fn figures_of_one_object_share_fields_of_equal_margin() {
        let library = hypertexture::shader::shipped();
        let scenes = checked(&library, &effects("knot").unwrap()).unwrap();
        let margins: Vec<f32> = objects(&scenes).iter().map(|shared| shared.margin).collect();
        assert!(margins.len() < 6 && margins.contains(&0.5), "lit and solid, but not the flames: {margins:?}");
        assert!(margins.iter().enumerate().all(|(index, margin)| !margins[..index].contains(margin)), "{margins:?}");
    }
}
