//! `render --error-map`: how far each pixel is from the f64 reference.

use super::picture::Picture;
use crate::session::Prepared;
use crate::terminal::{absolute, announced};
use hypertexture::output::write_map;
use hypertexture::render::Frame;
use hypertexture::render::variant::Variant;
use hypertexture_measure::compare::report::images::heat_png;
use hypertexture_measure::metric::Errors;
use hypertexture_measure::reference::{TOLERANCE, reference};
use hypertexture_measure::statistics::largest;
use hypertexture_support::write_whole;
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

/// Writes the map of a picture: .exr with the absolute error of each channel of premultiplied linear RGBA, as
/// `estimate` how far the reference itself may be off, as far as samples say, and as `open` the opacity that they may have
/// overlooked; .png with the worst channel as a color.
pub(crate) fn write_error_map(picture: &Picture<'_>, frame: &Frame, path: &Path) -> Result<Value, Box<dyn Error>> {
    let Picture { prepared: Prepared { library, subject, .. }, variant: Variant { scene, .. }, quiet, tell, .. } =
        *picture;
    let known =
        announced(quiet, "error map", |progress| reference(library, scene, subject, TOLERANCE, progress, &|| false))?;
    let off: Vec<[f64; 4]> = (frame.pixels.iter().zip(&known.pixels))
        .map(|(found, known)| std::array::from_fn(|c| (f64::from(found[c]) - known[c]).abs()))
        .collect();
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("png")) {
        write_whole(path, &heat_png(&frame.pixels, &known.pixels, frame.size))
            .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    } else {
        let of = |c: usize| off.iter().map(|off| off[c] as f32).collect::<Vec<f32>>();
        let [estimate, open] =
            [&known.estimate, &known.open].map(|values| values.iter().map(|value| *value as f32).collect());
        let own = [("estimate", estimate), ("open", open)];
        let channels = [("R", of(0)), ("G", of(1)), ("B", of(2)), ("A", of(3))].into_iter().chain(own);
        write_map(path, frame.size, &channels.collect::<Vec<_>>())?;
    }
    let worst = |off: &[f64; 4]| largest(*off);
    let at = (0..off.len()).max_by(|a, b| worst(&off[*a]).total_cmp(&worst(&off[*b]))).unwrap_or(0);
    let [x, y] = [at % frame.size[0] as usize, at / frame.size[0] as usize];
    let errors = Errors::between(&frame.pixels, &known.pixels);
    let (Errors { rmse, max, p999, .. }, [by_samples, by_proof]) = (errors, [known.error(), known.bound()]);
    let (proven, pixels) = (known.proven(), known.pixels.len());
    tell(&format!(
        "error      rmse {rmse:.1e}, max {max:.1e} in pixel {x}, {y}, 99.9 % of the pixels below {p999:.1e}; estimated error of the \
             reference {by_samples:.0e}; proven bound {by_proof:.0e} ({proven} of {pixels} pixels fully proven)\nwrote {}\n",
        absolute(path)
    ));
    Ok(json!({
        "errors": errors, "worst_pixel": [x, y], "known_by_samples": by_samples, "known_by_proof": by_proof, "proven": proven,
        "pixels": pixels,
    }))
}
