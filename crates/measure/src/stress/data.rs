//! Cases 13, 27, 31, 34, 38 and 44: unions, texts that must not be, matter without end, data that is none, and codes.

use super::function::Function;
use super::{Lab, Row, StressError, power, with};
use crate::verify::homogeneous;
use glam::Vec3;
use hypertexture::field::{self, Request};
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::{ParameterValue, Projection, linear_to_srgb, srgb_to_linear};
use hypertexture::shape::{self, Mesh, Shape};

/// Case 13: what all but covers, united and cut.
pub(super) fn unions(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
    for (module, algebraic) in [("algebraic", true), ("minmax", false)] {
        let function = Function::new(lab, include_str!("boolean.glsl"), &[("boolean", module)])?;
        for (from, to) in [(-24.0, -12.0), (-12.0, 0.0)] {
            let seen = function.at([from, to, 0.0, 0.0])?;
            let setting = format!("densities 1 - {} to 1 - {}", power(from as i32), power(to as i32));
            // A density that all but is 1 is rounded to half a unit of its last place.
            let rounded = 2f64.powi(-24);
            let united = seen
                .iter()
                .map(|[found, _, a, b]| (1.0 - if algebraic { a * b } else { a.min(*b) }, *found, 3.0 * rounded));
            rows.push(Row::worst(&format!("union, {module}"), &setting, united));
            let cut = seen.iter().map(|[_, found, a, b]| {
                let (truth, off) = if algebraic { (a * b, rounded * (a + b)) } else { (a.min(*b), rounded) };
                (truth, *found, off + rounded * rounded)
            });
            rows.push(Row::worst(&format!("intersection of complements, {module}"), &setting, cut));
        }
    }
    Ok(rows)
}

/// Case 27: hashes of sines differ by device, and a `smoothstep` between equal edges is not defined.
pub(super) fn texts(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let bare = |text: &str| -> String {
        let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
        lines.flat_map(str::split_whitespace).collect()
    };
    let sources: Vec<(&str, String)> = lab.bench.library.sources().map(|(path, text)| (path, bare(text))).collect();
    let mut rows = Vec::new();
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
        rows.push(Row::said(what, setting, "in none", found.join(", "), found.is_empty() && sources.len() > 50));
    }
    Ok(rows)
}

/// Case 31: noise that all but turns a radius around: the object ends, and where its formula does not it is told.
pub(super) fn hulls(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let library = &lab.bench.library;
    let mut rows = Vec::new();
    for amplitude in [0.25, 0.9, 1.0, 1.1] {
        let scene = with(homogeneous("sphere", 20.0, Projection::Perspective), |scene| {
            scene.effect.warp = vec!["noisy".into()];
            (scene.image.size, scene.camera.zoom) = ([32, 32], 0.3);
            scene.parameters.insert("amplitude".into(), ParameterValue::Number(amplitude));
        });
        let subject = Subject::load(&scene, library, &|_| ())?;
        let frame = Renderer::new(lab.bench.gpu, library, &subject).render(&scene)?;
        let border =
            frame.pixels.iter().enumerate().filter(|(at, _)| at % 32 == 0 || at % 32 == 31 || at / 32 % 31 == 0);
        let known = border.map(|(_, pixel)| (0.0, f64::from(pixel[3]), 0.0));
        let setting = format!("amplitude {amplitude}");
        rows.push(Row::worst("nothing at the border of the picture", &setting, known.collect::<Vec<_>>()));
        // 1 / (1 - 0.866 a) is the farthest: above 2.25 it is held.
        let far = 1.0 / (1.0 - 0.75f64.sqrt() * f64::from(amplitude)) > 2.25;
        let found =
            frame.measurements.held_beyond.map_or("not held".into(), |radius| format!("held beyond {radius:.2}"));
        let is_held = frame.measurements.held_beyond.is_some();
        rows.push(Row::said(
            "told where lobes are held",
            &setting,
            if far { "held" } else { "not held" },
            found,
            far == is_held,
        ));
    }
    Ok(rows)
}

/// Case 34: voxels that are no numbers, and numbers too small for normal ones.
pub(super) fn voxels(_: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let header =
        "NRRD0004\ntype: float\ndimension: 3\nsizes: 3 3 3\nspacings: 1 1 1\nencoding: raw\nendian: little\n\n";
    let read = |bad: f32| {
        let values = (0..27).map(|at| if at == 13 { bad } else { at as f32 });
        let bytes: Vec<u8> = header.bytes().chain(values.flat_map(f32::to_le_bytes)).collect();
        shape::read("scan.nrrd", &bytes)
    };
    let mut rows = Vec::new();
    let found = read(f32::INFINITY).map_or_else(|error| error.to_string(), |_| "read".into());
    let ok = found.contains("13") && found.contains("scan.nrrd");
    rows.push(Row::said("a voxel", "inf", "refused by its index", found, ok));
    for (bad, told) in [(f32::NAN, "NaN"), (f32::NEG_INFINITY, "-inf")] {
        // Outside of what was scanned: the least of the other values.
        let ok = matches!(read(bad), Ok(Shape::Volume(volume)) if volume.values[13] == 0.0);
        rows.push(Row::said("a voxel", told, "outside", if ok { "outside" } else { "not outside" }, ok));
    }
    for small in [1e-40, -1e-45, f32::MIN_POSITIVE] {
        let ok =
            matches!(read(small), Ok(Shape::Volume(volume)) if volume.values.iter().all(|value| value.is_finite()));
        rows.push(Row::said("a voxel", format!("{small:e}"), "read", if ok { "read" } else { "refused" }, ok));
    }
    Ok(rows)
}

/// Case 38: meshes that are not closed, turned or torn have the inside that a person would see.
pub(super) fn meshes(_: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let corners: Vec<Vec3> = (0..8u8)
        .map(|at| Vec3::new(f32::from(at & 1), f32::from(at >> 1 & 1), f32::from(at >> 2)) * 2.0 - 1.0)
        .collect();
    let quads: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let whole: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let turned: Vec<[u32; 3]> =
        whole.iter().enumerate().map(|(at, [a, b, c])| if at % 3 == 0 { [*a, *c, *b] } else { [*a, *b, *c] }).collect();
    let twice: Vec<[u32; 3]> = whole.iter().chain(&whole[..4]).copied().collect();
    let mut rows = Vec::new();
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
        let [x, y, z] = field.grid.size;
        let places = (0..z).flat_map(|k| (0..y).flat_map(move |j| (0..x).map(move |i| (i, j, k))));
        let mut known = Vec::new();
        for ((i, j, k), value) in places.zip(&field.values) {
            let depth = field.grid.position(i, j, k).abs().max_element() - 1.0;
            // Near an opening nobody can tell; deep inside and well outside everybody can.
            if !(-0.55..0.3).contains(&depth) {
                known.push((f64::from(depth.signum()), f64::from(value.signum()), 0.0));
            }
        }
        rows.push(Row::worst("sign of the field", name, known));
    }
    Ok(rows)
}

/// Case 44: codes of sRGB come back.
pub(super) fn codes(_: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
    for bits in [8u32, 16] {
        let most = f64::from((1u32 << bits) - 1);
        let known = (0..1u32 << bits).map(|code| {
            let back = linear_to_srgb(srgb_to_linear((f64::from(code) / most) as f32));
            (f64::from(code), f64::from(back) * most, 0.45)
        });
        rows.push(Row::worst("codes of sRGB, there and back", format!("{bits} bits"), known));
    }
    let falls = (0..1u32 << 16).map(|code| {
        let at = |code: u32| f64::from(srgb_to_linear(code as f32 / 65536.0));
        (0.0, (at(code) - at(code + 1)).max(0.0), 0.0)
    });
    rows.push(Row::worst("the curve rises", "65536 places", falls));
    Ok(rows)
}
