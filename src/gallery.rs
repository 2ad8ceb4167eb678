//! The gallery: the effects of MJ Fig. 7 on one object, and a page that explains them.

use crate::field::Progress;
use crate::glsl::Library;
use crate::glsl::library::Default as KnobDefault;
use crate::gpu::Gpu;
use crate::output::{self, Depth, OutputError};
use crate::render::{RenderError, Subject, render};
use crate::scene::{Color, EFFECTS, KnobValue, Scene, SceneError, preset};
use crate::variant::Variant;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Why there is no gallery.
#[derive(Debug, thiserror::Error)]
pub enum GalleryError {
    /// A scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture cannot be made.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Voxels along the longest side of the field. Fewer: thin parts, such as the lip of the teapot, look frayed.
const RESOLUTION: u32 = 256;

/// The six effects on an object, by name.
///
/// # Errors
/// A shipped preset that cannot be read, which its test excludes.
pub fn scenes(input: &str) -> Result<Vec<(String, Scene)>, SceneError> {
    let on_input = |name: &str| {
        preset(name).map(|mut scene| {
            scene.object.input = input.into();
            scene.object.resolution = RESOLUTION;
            scene.image.background = Some(Color([24, 26, 31]));
            (name.to_string(), scene)
        })
    };
    EFFECTS.iter().map(|name| on_input(name)).collect()
}

/// Renders the scenes, which share one object, into `folder` and writes `index.html` there; returns its path.
///
/// # Errors
/// A scene without a picture, or a file that cannot be written.
pub fn write(
    gpu: &Gpu,
    library: &Library,
    scenes: &[(String, Scene)],
    folder: &Path,
    progress: Progress<'_>,
) -> Result<PathBuf, GalleryError> {
    let (mut margin, mut closest) = (0f32, false);
    for (_, scene) in scenes {
        let knobs = scene.check(library)?;
        margin = margin.max(knobs.outer_iso().unwrap_or(scene.object.outer_iso));
        closest |= Variant::of(scene, library).map_err(RenderError::from)?.reads_closest();
    }
    let field_share = 0.3;
    let object = &scenes.first().map(|(_, scene)| scene.object.clone()).unwrap_or_default();
    let subject = Subject::load_with_margin(object, margin, closest, &|fraction| progress(field_share * fraction))?;
    let io = |path: &Path| {
        let path = path.display().to_string();
        move |source| OutputError::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(io(folder))?;
    let mut figures = String::new();
    for (index, (name, scene)) in scenes.iter().enumerate() {
        let frame = render(gpu, library, scene, &subject)?;
        let file = format!("{name}.png");
        output::write(&frame, scene.image.background, Depth::Eight, &frame.measurements.modules, &folder.join(&file))?;
        let variant = Variant::of(scene, library).map_err(RenderError::from)?;
        let m = &frame.measurements;
        write!(
            figures,
            "<figure><img src=\"{file}\" width=\"{}\" height=\"{}\" alt=\"{name} on {}\">\n<figcaption><h2>{name}</h2><p>{}</p>\n{}\n\
             <p class=\"cost\">{} slices, {:.0} ms on the device. Modules: <code>{}</code>. Left out: {}.</p>\n\
             <p><code>hypertexture render {} --effect {name} -o {file}</code></p></figcaption></figure>\n",
            scene.image.size[0], scene.image.size[1], escape(&scene.object.input), escape(&scene.about),
            knob_table(&variant), m.slices, m.gpu_ms, escape(&m.modules),
            if m.left_out.is_empty() { "nothing".into() } else { m.left_out.join(", ") },
            escape(&scene.object.input),
        )
        .expect("writing to a string");
        progress(field_share + (1.0 - field_share) * (index + 1) as f32 / scenes.len() as f32);
    }
    let facts = gpu.facts();
    let page = PAGE
        .replace("{object}", &escape(&object.input))
        .replace("{device}", &escape(&format!("{} ({})", facts.name, facts.driver)))
        .replace("{figures}", &figures);
    let path = folder.join("index.html");
    output::write_whole(&path, page.as_bytes()).map_err(io(&path))?;
    Ok(path)
}

fn knob_table(variant: &Variant) -> String {
    let mut table = String::from("<table>\n");
    for (knob, value) in variant.knobs.iter() {
        let value = match value {
            KnobValue::Number(number) => number.to_string(),
            KnobValue::Color(color) => String::from(*color),
        };
        let range = match knob.default {
            KnobDefault::Number(_, [low, high]) => format!("{low} to {high}"),
            KnobDefault::Color(_) => "color".into(),
        };
        let cells = format!("<td><code>{}</code><td>{value}<td>{range}<td>{}", knob.name, escape(&knob.doc));
        writeln!(table, "<tr>{cells}</tr>").expect("writing to a string");
    }
    table + "</table>"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

const PAGE: &str = include_str!("gallery.html");
