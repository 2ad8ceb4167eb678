//! The page of `hypertexture web`.

use crate::describe::{check, describe};
use crate::packed::{left_out, pack};
use crate::wgsl::{constant, wgsl};
use crate::{ExportError, File};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hypertexture::render::{Portable, PortableImage};
use rayon::prelude::*;
use serde_json::json;
use std::fmt::Write;

/// Modules in the order of their imports.
const MODULES: [(&str, &str); 6] = [
    ("matrix.js", include_str!("../page/matrix.js")),
    ("texels.js", include_str!("../page/texels.js")),
    ("camera.js", include_str!("../page/camera.js")),
    ("gpu.js", include_str!("../page/gpu.js")),
    ("controls.js", include_str!("../page/controls.js")),
    ("main.js", include_str!("../page/main.js")),
];
const PAGE: &str = include_str!("../page/index.html");
const STYLE: &str = include_str!("../page/style.css");
/// Says why a folder that is opened from disk stays still.
const FROM_DISK: &str = "<script>if (location.protocol === 'file:') document.getElementById('status').textContent =\n\
     'Browsers load no modules from disk: serve the folder, python3 -m http.server, or make one file with --single-file.';\n\
     </script>";

/// A page to write.
pub struct Page<'a> {
    /// Title.
    pub title: &'a str,
    /// The command that makes it.
    pub command: &'a str,
    /// The picture, as PNG.
    pub picture: &'a [u8],
    /// Whether all is in one file.
    pub is_single: bool,
}

/// The files of a page: `index.html`, and what it loads.
///
/// # Errors
/// [`ExportError::Wgsl`] and [`ExportError::Large`].
pub fn page(portable: &Portable, page: &Page<'_>) -> Result<Vec<File>, ExportError> {
    check(portable)?;
    let mut data = Vec::new();
    for own in &portable.programs {
        data.push((format!("{}.wgsl", own.name), wgsl(own.name, &constant(portable, own)?)?.into_bytes()));
    }
    let file = |image: &PortableImage| format!("{}.gz", image.name);
    let described = |image: &PortableImage| json!({ "packed": file(image), "left_out": left_out(image) });
    data.par_extend(portable.images.par_iter().map(|image| (file(image), pack(portable, image))));
    data.push(("scene.json".into(), describe(portable, page.command, described).to_string().into_bytes()));
    let scene = &portable.variant.scene;
    let [width, height] = scene.image.size;
    let (style, scripts, picture) = match page.is_single {
        true => (format!("<style>\n{STYLE}</style>"), inline(&data), base64_url("image/png", page.picture)),
        false => (
            "<link rel=\"stylesheet\" href=\"style.css\">".into(),
            format!("<script type=\"module\" src=\"main.js\"></script>\n{FROM_DISK}"),
            "picture.png".into(),
        ),
    };
    let html = PAGE
        .replace("{style}", &style)
        .replace("{scripts}", &scripts)
        .replace("{picture}", &picture)
        .replace("{title}", &escape(&page.title.replace('_', " ")))
        .replace("{about}", &escape(&scene.about))
        .replace("{command}", &escape(page.command))
        .replace("{aspect}", &(f64::from(width) / f64::from(height)).to_string())
        .replace("{width}", &width.to_string())
        .replace("{height}", &height.to_string());
    let index = ("index.html".to_string(), html.into_bytes());
    if page.is_single {
        return Ok(vec![index]);
    }
    let text = |(name, text): (&str, &str)| (name.to_string(), text.as_bytes().to_vec());
    data.extend(MODULES.into_iter().chain([("style.css", STYLE)]).map(text));
    data.extend([("picture.png".into(), page.picture.to_vec()), index]);
    Ok(data)
}

/// The files as elements of the page, and the modules as one.
fn inline(files: &[File]) -> String {
    let mut text = String::new();
    for (name, bytes) in files {
        let encoded = STANDARD.encode(bytes);
        writeln!(text, "<script type=\"text/plain\" id=\"file:{name}\">{encoded}</script>")
            .expect("writing to a string");
    }
    let lines = MODULES.iter().flat_map(|(_, module)| module.lines()).filter(|line| !line.starts_with("import "));
    let lines: Vec<&str> = lines.map(|line| line.strip_prefix("export ").unwrap_or(line)).collect();
    text + "<script type=\"module\">\n" + &lines.join("\n") + "\n</script>"
}

fn base64_url(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
