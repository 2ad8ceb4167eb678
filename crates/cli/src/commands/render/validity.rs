//! `render --validity`: doubtful pixels and their cause.

use super::picture::Picture;
use crate::session::Prepared;
use crate::terminal::{absolute, announced};
use hypertexture::render::Frame;
use hypertexture::scene::RayPath;
use hypertexture_measure::compare::report::images::png_of;
use hypertexture_measure::reference::{TOLERANCE, reference};
use hypertexture_measure::validity::{Found, OPEN, TRUSTED, Validity, validity};
use hypertexture_support::write_whole;
use serde_json::{Value, json};
use std::convert::Infallible;
use std::error::Error;
use std::path::Path;

/// Writes the validity of a picture: doubtful pixels in the color of their cause, the others in grey.
pub(crate) fn write_validity(picture: &Picture<'_>, frame: &Frame, path: &Path) -> Result<Value, Box<dyn Error>> {
    let Picture { gpu, prepared: Prepared { library, subject, .. }, variant, quiet, tell, .. } = *picture;
    let scene = &variant.scene;
    let mut validity = announced(quiet, "validity", |progress| {
        progress(0.0);
        Ok::<_, Infallible>(validity(gpu, library, scene, subject, frame))
    })?;
    let known = announced(quiet, "reference", |progress| {
        Ok::<_, Infallible>(match scene.effect.ray_path {
            RayPath::Refracted => {
                Err("no bounds follow a ray that bends; --error-map compares it with its reference".to_string())
            }
            _ => reference(library, scene, subject, TOLERANCE, progress, &|| false).map_err(|error| error.to_string()),
        })
    })?;
    validity.add_open(&frame.pixels, known.as_ref().map_err(Clone::clone));
    write_whole(path, &png_of(frame.size, &validity.colors(&frame.pixels)))
        .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    tell(&format!("{}wrote {}\n", words(&validity), absolute(path)));
    let causes = validity.found.iter().map(|Found { cause, most, pixels }| {
        json!({ "cause": cause.name, "why": cause.why, "pixels": pixels, "most": most.as_ref().ok(), "untried": most.as_ref().err() })
    });
    Ok(
        json!({ "trusted_percent": validity.trusted(), "pixels": validity.covered, "causes": causes.collect::<Vec<_>>() }),
    )
}

fn words(validity: &Validity) -> String {
    let is_proven = validity.found.iter().any(|found| found.cause.name == OPEN.name && found.most.is_ok());
    let proven = if is_proven { "are proven to miss no matter, and " } else { "" };
    let mut text = format!(
        "validity   {:.1} % of {} pixels {proven}change by less than {TRUSTED:.1e} with any better setting\n",
        validity.trusted(),
        validity.covered
    );
    for Found { cause, most, pixels } in &validity.found {
        let [r, g, b] = cause.color;
        text += &match most {
            Err(error) => format!("  {:<9} not tried: {error}\n", cause.name),
            Ok(most) if *pixels == 0 => format!("  {:<9} of none; at most {most:.1e}\n", cause.name),
            Ok(most) => format!(
                "  {:<9} of {:.1} % (#{r:02x}{g:02x}{b:02x}), at most {most:.1e}: {}\n",
                cause.name,
                validity.percent(*pixels),
                cause.why
            ),
        };
    }
    text
}
