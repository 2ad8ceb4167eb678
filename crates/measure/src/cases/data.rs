//! Unions, undefined GLSL, unbounded matter, bad voxels, open meshes and codes of colors.

use super::function::Function;
use super::lab::{CaseError, Lab, Rows};
use super::scenes::{homogeneous, indices};
use glam::Vec3;
use hypertexture::field::{self, Request};
use hypertexture::render::RenderError;
use hypertexture::scene::{ParameterValue, Projection, linear_to_srgb, srgb_to_linear};
use hypertexture::shape::{self, Mesh, Shape};

/// Unions and intersections of densities close to 1.
pub(super) fn unions(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for (module, algebraic) in [("algebraic", true), ("minmax", false)] {
        let function = Function::new(lab, include_str!("boolean.glsl"), &[("boolean", module)])?;
        for (from, to) in [(-24.0, -12.0), (-12.0, 0.0)] {
            let seen = function.at([from, to, 0.0, 0.0])?;
            let setting = format!("densities 1 - 2^{from} to 1 - 2^{to}");
            // A density close to 1 is rounded to half a unit in its last place.
            let rounded = 2f64.powi(-24);
            let united = seen
                .iter()
                .map(|[found, _, a, b]| (1.0 - if algebraic { a * b } else { a.min(*b) }, *found, 3.0 * rounded));
            rows.worst(format!("union, {module}"), &setting, united);
            let cut = seen.iter().map(|[_, found, a, b]| {
                let (truth, off) = if algebraic { (a * b, rounded * (a + b)) } else { (a.min(*b), rounded) };
                (truth, *found, off + rounded * rounded)
            });
            rows.worst(format!("intersection of complements, {module}"), &setting, cut);
        }
    }
    Ok(())
}

/// Hashes of sines differ between devices, and `smoothstep` between equal edges is undefined.
pub(super) fn texts(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let bare = |text: &str| -> String {
        let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
        lines.flat_map(str::split_whitespace).collect()
    };
    let sources: Vec<(&str, String)> = lab.library.sources().map(|(path, text)| (path, bare(text))).collect();
    for (what, is_wrong) in [
        (
            "fract of a sine",
            (|text: &str| text.contains("fract(sin(") || text.contains("fract(cos(")) as fn(&str) -> bool,
        ),
        ("modulo of what may be negative", |text| text.contains("int(floor(") && text.contains(")%")),
        ("equal edges", |text| {
            text.split("smoothstep(").skip(1).any(|rest| {
                let mut edges = rest.split(',').map(|edge| edge.parse::<f64>().ok());
                matches!((edges.next(), edges.next()), (Some(Some(a)), Some(Some(b))) if a >= b)
            })
        }),
    ] {
        let found: Vec<&str> = sources.iter().filter(|(_, text)| is_wrong(text)).map(|(path, _)| *path).collect();
        let setting = format!("{} files", sources.len());
        rows.holds(what, setting, "in none", found.join(", "), found.is_empty() && sources.len() > 50);
    }
    Ok(())
}

/// Noise close to inverting a radius: the object ends within the picture, and a limited radius is reported.
pub(super) fn hulls(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for amplitude in [0.25, 0.9, 1.0, 1.1] {
        let mut scene = homogeneous("sphere", 20.0, Projection::Perspective);
        scene.effect.warp = vec!["noisy".into()];
        (scene.image.size, scene.camera.zoom) = ([32, 32], 0.3);
        scene.parameters.insert("amplitude".into(), ParameterValue::Number(amplitude));
        let frame = lab.render(&scene, &lab.subject(&scene)?)?;
        let border =
            frame.pixels.iter().enumerate().filter(|(at, _)| at % 32 == 0 || at % 32 == 31 || at / 32 % 31 == 0);
        let known = border.map(|(_, pixel)| (0.0, f64::from(pixel[3]), 0.0));
        let setting = format!("amplitude {amplitude}");
        rows.worst("opacity at the border of the picture", &setting, known);
        // The farthest point is at 1 / (1 - 0.866 a), limited to 2.25.
        let far = 1.0 / (1.0 - 0.75f64.sqrt() * f64::from(amplitude)) > 2.25;
        let found =
            frame.measurements.held_beyond.map_or("unlimited".into(), |radius| format!("limited to {radius:.2}"));
        let is_held = frame.measurements.held_beyond.is_some();
        rows.holds(
            "reported limit of the radius",
            &setting,
            if far { "limited" } else { "unlimited" },
            found,
            far == is_held,
        );
    }
    Ok(())
}

/// Voxels that are not finite, and subnormal ones.
pub(super) fn voxels(_: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let header =
        "NRRD0004\ntype: float\ndimension: 3\nsizes: 3 3 3\nspacings: 1 1 1\nencoding: raw\nendian: little\n\n";
    let read = |bad: f32| {
        let values = (0..27).map(|at| if at == 13 { bad } else { at as f32 });
        let bytes: Vec<u8> = header.bytes().chain(values.flat_map(f32::to_le_bytes)).collect();
        shape::read("scan.nrrd", &bytes)
    };
    let found = read(f32::INFINITY).map_or_else(|error| error.to_string(), |_| "read".into());
    let ok = found.contains("13") && found.contains("scan.nrrd");
    rows.holds("a voxel", "inf", "an error with its index", found, ok);
    for (bad, name) in [(f32::NAN, "NaN"), (f32::NEG_INFINITY, "-inf")] {
        // Outside of the scan: the smallest of the other values.
        let ok = matches!(read(bad), Ok(Shape::Volume(volume)) if volume.values[13] == 0.0);
        rows.holds("a voxel", name, "outside", if ok { "outside" } else { "not outside" }, ok);
    }
    for small in [1e-40, -1e-45, f32::MIN_POSITIVE] {
        let ok =
            matches!(read(small), Ok(Shape::Volume(volume)) if volume.values.iter().all(|value| value.is_finite()));
        rows.holds("a voxel", format!("{small:e}"), "read", if ok { "read" } else { "refused" }, ok);
    }
    Ok(())
}

/// Meshes with holes, flipped or doubled triangles have the inside that a person would see.
pub(super) fn meshes(_: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let corners: Vec<Vec3> = (0..8u8)
        .map(|at| Vec3::new(f32::from(at & 1), f32::from(at >> 1 & 1), f32::from(at >> 2)) * 2.0 - 1.0)
        .collect();
    let quads: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let whole: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let turned: Vec<[u32; 3]> =
        whole.iter().enumerate().map(|(at, [a, b, c])| if at % 3 == 0 { [*a, *c, *b] } else { [*a, *b, *c] }).collect();
    let twice: Vec<[u32; 3]> = whole.iter().chain(&whole[..4]).copied().collect();
    for (name, triangles) in [
        ("cube", whole.clone()),
        ("cube, a third of it turned", turned),
        ("cube without a triangle", whole[1..].to_vec()),
        ("cube without a side", whole[2..].to_vec()),
        ("cube with faces twice", twice),
        ("cube turned inside out", whole.iter().map(|[a, b, c]| [*a, *c, *b]).collect()),
    ] {
        let shape = Shape::Mesh(Mesh { positions: corners.clone(), triangles, ..Mesh::default() });
        let request = Request { resolution: 24, margin: 0.5, band: 0.5, iso: 0.0, shell: 0.0 };
        let (field, _) = field::transform(&shape, &request, &|_| ()).map_err(RenderError::from)?;
        let known = indices(field.grid.size).zip(&field.values).filter_map(|([i, j, k], value)| {
            let depth = field.grid.position(i, j, k).abs().max_element() - 1.0;
            let is_near = (-0.55..0.3).contains(&depth); // the sign is ambiguous near an opening
            (!is_near).then(|| (f64::from(depth.signum()), f64::from(value.signum()), 0.0))
        });
        rows.worst("sign of the field", name, known);
    }
    Ok(())
}

/// Codes of sRGB survive a round trip.
pub(super) fn codes(_: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for bits in [8u32, 16] {
        let most = f64::from((1u32 << bits) - 1);
        let known = (0..1u32 << bits).map(|code| {
            let back = linear_to_srgb(srgb_to_linear((f64::from(code) / most) as f32));
            (f64::from(code), f64::from(back) * most, 0.45)
        });
        rows.worst("round trip of sRGB codes", format!("{bits} bits"), known);
    }
    let falls = (0..1u32 << 16).map(|code| {
        let at = |code: u32| f64::from(srgb_to_linear(code as f32 / 65536.0));
        (0.0, (at(code) - at(code + 1)).max(0.0), 0.0)
    });
    rows.worst("monotonic sRGB curve", "65536 places", falls);
    Ok(())
}
