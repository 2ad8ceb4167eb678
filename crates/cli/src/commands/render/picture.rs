//! A picture or a shard: rendering, writing, and the summary.

use crate::session::Prepared;
use crate::terminal::{absolute, with_progress};
use hypertexture::field::DistanceField;
use hypertexture::gpu::Gpu;
use hypertexture::output::shard::{self, Shard};
use hypertexture::output::{Depth, Provenance, ProvenanceError, encode_png, identity, write};
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, RenderError, Renderer, Subject, half_height, octaves_held, warnings};
use hypertexture::scene::schema::{Kind, setting};
use hypertexture::scene::{Pass, Scene};
use hypertexture::shader::Library;
use hypertexture_support::write_whole;
use serde_json::{Map, Value, json};
use std::error::Error;
use std::io::Write;
use std::path::Path;

/// Size of a voxel in pixels from which on edges look stepped.
const SEEN_VOXEL: f32 = 6.0;

/// Output name of standard output.
pub(crate) const STANDARD_OUTPUT: &str = "-";

/// A picture on an open device.
#[derive(Clone, Copy)]
pub(crate) struct Picture<'a> {
    pub(crate) gpu: &'a Gpu,
    /// The scene as requested, its modules and its object.
    pub(crate) prepared: &'a Prepared,
    /// The scene of the picture, which `--max-error` may have changed.
    pub(crate) variant: &'a Variant,
    /// Files of modules whose text is in no file of the scene.
    pub(crate) edited: &'a [String],
    /// Output file, or the pattern of the files of frames.
    pub(crate) output: &'a Path,
    /// Bits of each channel of a PNG: 8 or 16.
    pub(crate) depth: &'a str,
    pub(crate) quiet: bool,
    /// Receives messages.
    pub(crate) tell: fn(&str),
}

impl Picture<'_> {
    /// Bits of each channel of a PNG.
    pub(crate) fn depth(&self) -> Depth {
        if self.depth == "16" { Depth::Sixteen } else { Depth::Eight }
    }

    /// The provenance of a frame.
    pub(crate) fn provenance(&self, scene: &Scene, frame: &Frame) -> Result<Provenance, ProvenanceError> {
        let mut measured = frame.measurements.clone();
        if !self.edited.is_empty() {
            measured.modules += &format!("; edited in the window: {}", self.edited.join(", "));
        }
        Provenance::of(scene, &self.gpu.info().title(), &measured)
    }
}

/// Renders a picture, unless it is `drawn` already, and writes the file.
pub(crate) fn render_picture(picture: &Picture<'_>, drawn: Option<Frame>) -> Result<Frame, Box<dyn Error>> {
    let Picture { gpu, prepared: Prepared { library, subject, .. }, variant, output, quiet, tell, .. } = *picture;
    let scene = &variant.scene;
    let frame = match drawn {
        Some(drawn) => drawn,
        None => draw(gpu, library, variant, subject, quiet)?,
    };
    let provenance = picture.provenance(scene, &frame)?;
    let (background, depth) = (scene.image.background, picture.depth());
    if output == Path::new(STANDARD_OUTPUT) {
        let png = encode_png(&frame, background, depth, &provenance)?;
        let mut out = std::io::stdout().lock();
        out.write_all(&png).and_then(|()| out.flush()).map_err(|error| format!("standard output: {error}"))?;
    } else {
        write(&frame, background, depth, &provenance, output)?;
    }
    if !quiet {
        tell(&summary(picture, &frame));
        tell(&nothing_seen(scene, subject, &frame).map_or(String::new(), |why| format!("empty      {why}\n")));
    }
    if output != Path::new(STANDARD_OUTPUT) {
        tell(&format!("wrote {}\n", absolute(output)));
    }
    Ok(frame)
}

/// Renders a picture.
pub(crate) fn draw(
    gpu: &Gpu,
    library: &Library,
    variant: &Variant,
    subject: &Subject,
    quiet: bool,
) -> Result<Frame, RenderError> {
    let mut renderer = Renderer::new(gpu, library, subject);
    with_progress(quiet, "noise", |progress| renderer.prepare(variant, progress))?;
    with_progress(quiet, "picture", |progress| renderer.render_with(variant, progress))
}

/// Explanation of an empty picture.
fn nothing_seen(scene: &Scene, subject: &Subject, frame: &Frame) -> Option<String> {
    if frame.pixels.iter().any(|[.., alpha]| *alpha > 0.0) {
        return None;
    }
    // Samples that lie less than half a voxel deep are lost between two.
    let deepest = |field: &DistanceField| field.range().0 * subject.scale - scene.object.inner_iso;
    let voxel = |field: &DistanceField| field.grid.spacing.max_element() * subject.scale;
    let is_thin = |field: &&DistanceField| deepest(field) > -0.5 * voxel(field);
    Some(match subject.field.as_deref().filter(is_thin) {
        Some(field) => {
            let remedies = remedies(scene, field, voxel(field));
            format!(
                "no voxel is inside of the object by half its side: it has no inside, or is thinner than one ({:.2e} object units); {remedies}",
                voxel(field)
            )
        }
        None => "no ray meets matter: look at the view (camera.zoom, camera.pan, camera.clip) and at what makes the object opaque \
                 (its iso-values, the transfer map, the parameters of the effect)"
            .into(),
    })
}

/// Remedies for an object that is thinner than a voxel.
fn remedies(scene: &Scene, field: &DistanceField, voxel: f32) -> String {
    let most = |name: &str| match setting(name).map(|setting| setting.kind) {
        Some(Kind::Whole(range) | Kind::Number(range)) => range.high,
        _ => f32::INFINITY,
    };
    let [finest, thickest] = ["object.resolution", "object.shell"].map(most);
    let own = scene.object.resolution as f32;
    // The samples of a scan are those of its file.
    let spans = field.grid.size.iter().max().copied().unwrap_or(1) as f32;
    let resolution = (own < finest && spans >= own).then(|| {
        format!(
            "a larger --resolution if it is thicker than {:.1e} (the finest voxel, at {finest})",
            voxel * own / finest
        )
    });
    let shell = (2.0 * voxel <= thickest).then(|| format!("a shell around its surface by --shell {:.2e}", 2.0 * voxel));
    let all: Vec<String> = resolution.into_iter().chain(shell).collect();
    if all.is_empty() {
        "write it with several voxels across its thinnest side, or thicken it in the program that it comes from".into()
    } else {
        all.join(", or ")
    }
}

/// Renders a shard of a picture and writes the file.
pub(crate) fn render_shard(picture: &Picture<'_>, shard: Shard) -> Result<Frame, Box<dyn Error>> {
    let Picture { gpu, prepared: Prepared { library, subject, .. }, variant, output, quiet, tell, .. } = *picture;
    let scene = &variant.scene;
    let bands = shard.bands(scene.image.size[1]);
    let frame = with_progress(quiet, "picture", |progress| {
        let mut renderer = Renderer::new(gpu, library, subject);
        renderer.prepare(variant, progress)?;
        renderer.render_bands(variant, &bands)
    })?;
    let whole = shard::Whole {
        identity: identity(variant, library, subject)?,
        size: scene.image.size,
        background: scene.image.background,
        depth: picture.depth(),
        provenance: picture.provenance(scene, &frame)?,
    };
    let path = shard.path(output);
    write_whole(&path, &shard::encode(&whole, shard, &frame))
        .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    if !quiet {
        tell(&summary(picture, &frame));
    }
    tell(&format!("wrote {}\n", absolute(&path)));
    Ok(frame)
}

/// Scene, notes and measurements of a picture as JSON.
pub(crate) fn object(picture: &Picture<'_>, frame: &Frame) -> Result<Map<String, Value>, Box<dyn Error>> {
    let Picture { prepared: Prepared { subject, began, loading_ms, .. }, variant: Variant { scene, .. }, .. } =
        *picture;
    let field = subject.field.as_ref().zip(subject.report.as_ref()).map(|(field, report)| {
        json!({
            "size": field.grid.size, "from_cache": report.from_cache, "ms": report.ms, "triangles": report.triangles,
            "open_edges": report.open_edges, "closing_triangles": report.closing_triangles,
        })
    });
    let notes = notes(picture, frame).into_iter().map(|(about, what)| json!({ "about": about, "what": what }));
    let object = [
        ("scene", serde_json::to_value(scene)?),
        ("field", json!(field)),
        ("notes", notes.collect()),
        ("empty", json!(nothing_seen(scene, subject, frame))),
        ("measurements", serde_json::to_value(&frame.measurements)?),
        ("loading_ms", json!(loading_ms)),
        ("all_ms", json!(began.elapsed().as_secs_f64() * 1e3)),
    ];
    Ok(object.into_iter().map(|(name, value)| (name.to_string(), value)).collect())
}

/// Notes on a picture: subject and text.
fn notes(picture: &Picture<'_>, frame: &Frame) -> Vec<(&'static str, String)> {
    let Picture { prepared: Prepared { library, subject, .. }, variant, .. } = *picture;
    let m = &frame.measurements;
    let mut notes: Vec<_> = coarse(variant, subject).map(|text| ("voxels", text)).into_iter().collect();
    notes.extend(octaves_held(m, variant, library).map(|text| ("octaves", text)));
    notes.extend(warnings(m, variant, subject, library).into_iter().map(|text| ("note", text)));
    notes
}

/// Time of a render and the work that it left out.
fn summary(picture: &Picture<'_>, frame: &Frame) -> String {
    let Picture { gpu, prepared: Prepared { subject, began, loading_ms, .. }, variant, .. } = *picture;
    let scene = &variant.scene;
    let info = gpu.info();
    let m = &frame.measurements;
    let mut lines = vec![
        format!("device     {} ({}, Vulkan {})", info.name, info.driver, info.api),
        format!("program    {}{}", m.modules, if m.shipped { "" } else { " (linked for it)" }),
        format!("left out   {}", if m.left_out.is_empty() { "nothing".into() } else { m.left_out.join(", ") }),
    ];
    if let (Some(field), Some(report)) = (&subject.field, &subject.report) {
        let [x, y, z] = field.grid.size;
        let origin = if report.from_cache { "from the cache" } else { "computed" };
        lines.push(format!(
            "field      {x} x {y} x {z}, {origin} in {:.0} ms; {} triangles, {} open edges, {} closing; stored to {:.1e} object units",
            report.ms, report.triangles, report.open_edges, report.closing_triangles, m.quantization
        ));
    }
    lines.extend(notes(picture, frame).into_iter().map(|(about, what)| format!("{about:<11}{what}")));
    lines.push(match (scene.quality.pass, m.fragments) {
        (Pass::Slices, count) => {
            let count = count.map_or(String::new(), |count| format!(", {:.1} M fragments", count as f64 * 1e-6));
            format!("slices     {} of thickness {:.5} object units{count}", m.slices, m.step)
        }
        (Pass::March, count) => {
            let count = count.map_or(String::new(), |count| format!("{count}, "));
            format!("rays       {count}at most {} samples each, {:.5} object units apart", m.slices, m.step)
        }
    });
    lines.extend(m.cells.as_ref().map(|cells| format!("cells      {cells}")));
    if let Some(radius) = m.held_beyond {
        lines.push(format!(
            "held       beyond {radius:.2} object units from the center a warp keeps its step: lobes are shorter than its formula"
        ));
    }
    if let Some(shadow_ms) = m.shadow_ms {
        lines.push(format!("shadows    {:.1} ms", shadow_ms + m.shadow_before_ms));
    }
    let all_ms = began.elapsed().as_secs_f64() * 1e3;
    lines.push(format!(
        "time       {:.1} ms on the device (longest submission {:.1} ms), {loading_ms:.0} ms to load, {:.0} ms to compile, {all_ms:.0} ms in all",
        m.gpu_ms, m.longest_ms, m.compile_ms
    ));
    if let Some(sparse) = m.sparse {
        let [bytes, dense] = [sparse.bytes, sparse.dense_bytes].map(|bytes| bytes as f64 / f64::from(1 << 20));
        let (stored, bricks) = (sparse.stored, sparse.bricks);
        lines.push(format!("bricks     {stored} of {bricks} stored: {bytes:.1} MiB in place of {dense:.1} MiB"));
    }
    lines.push(format!("memory     {:.1} MiB of images on the device\n", m.device_bytes as f64 / f64::from(1 << 20)));
    lines.join("\n")
}

/// Note on visible voxels.
fn coarse(variant: &Variant, subject: &Subject) -> Option<String> {
    let (scene, field) = (&variant.scene, subject.field.as_ref()?);
    let pixel = 2.0 * half_height(variant, subject) / scene.image.size[1] as f32;
    let pixels = field.grid.spacing.max_element() * subject.scale / pixel;
    let Kind::Whole(range) = setting("object.resolution")?.kind else { return None };
    let finer = (2 * scene.object.resolution).min(range.high as u32);
    let is_seen = pixels > SEEN_VOXEL && scene.object.resolution < finer;
    is_seen.then(|| {
        format!("{pixels:.0} pixels wide: sharp edges of the object show them; --resolution {finer} has finer ones")
    })
}
