//! Description of the contents of a file, for people and programs.
//!
//! Invariant: depends on the file alone, not on the settings of a scene.

use crate::built_in::BUILT_IN;
use crate::error::ShapeError;
use crate::groom::Groom;
use crate::open::Opened;
use crate::shape::{Content, Histogram, Mesh, Shape, Solid, Volume};
use crate::unit::Unit;
use glam::{DVec3, Vec3};
use hypertexture_support::significant;
use serde::Serialize;
use serde_json::{Value, json};
use std::ops::RangeInclusive;

/// Slope at 0 of scalars that look like signed distances, per world unit.
const SLOPE: RangeInclusive<f32> = 0.95..=1.05;

/// Lowest value of a CT scan in Hounsfield units: air is -1000, some scanners pad with lower values.
const AIR: RangeInclusive<f32> = -3100.0..=-900.0;

/// One line of a description.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// Topic, one word.
    pub name: &'static str,
    /// Text for people.
    pub words: String,
    /// Value for programs.
    pub value: Value,
}

/// Description of a file or a built-in object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts {
    /// Lines of the description, with the notes of the reader.
    pub lines: Vec<Fact>,
    /// Corners of the bounding box, in world units of the file.
    pub corners: [DVec3; 2],
    /// Histogram of a scalar volume.
    pub histogram: Option<Histogram>,
    /// Ascending iso-values between materials of a scalar volume.
    pub iso_values: Vec<f32>,
    /// Whether scalars have the slope of signed distances at 0.
    pub is_like_distances: bool,
}

impl Facts {
    /// Reads a file or makes a built-in object, and describes it.
    ///
    /// # Errors
    /// Those of [`Opened::with_grid`].
    pub fn of(input: &str, grid: Option<&str>) -> Result<Facts, ShapeError> {
        let Opened { shape, notes, grids, names, unit, .. } = Opened::with_grid(input, grid)?;
        let mut facts = match &shape {
            Shape::Solid(solid) => of_solid(solid),
            Shape::Mesh(mesh) => of_mesh(mesh),
            Shape::Volume(volume) => of_volume(volume),
        };
        if !grids.is_empty() {
            facts.lines.push(fact("grids", grids.join(", "), &grids));
        }
        if !names.is_empty() {
            facts.lines.push(fact("names", names.join(", "), &names));
        }
        if !notes.is_empty() {
            facts.lines.push(fact("notes", notes.join("; "), &notes));
        }
        let offset = if let Shape::Mesh(mesh) = &shape { mesh.offset } else { DVec3::ZERO };
        let bounds = shape.bounds();
        facts.corners = [bounds.min, bounds.max].map(|corner| corner.as_dvec3() + offset);
        facts.lines.push(fact(
            "box",
            in_words(facts.corners, bounds.size()),
            facts.corners.map(|corner| corner.to_array()),
        ));
        let is_file = !BUILT_IN.contains(&input);
        facts.lines.push(print_size(bounds.size(), unit, is_file));
        Ok(facts)
    }

    /// Describes what is painted in a groom.
    pub fn of_groom(groom: &Groom) -> Facts {
        let (side, all) = (groom.side(), groom.voxels());
        let painted = (0..all).filter(|index| groom.at(*index) != Groom::NEUTRAL).count();
        let mut ends = [[f32::INFINITY, f32::NEG_INFINITY]; 5];
        for index in 0..all {
            for (channel, value) in groom.at(index).into_iter().enumerate() {
                let own = &mut ends[[0, 1, 2, 2, 2, 3, 3, 3, 4][channel]];
                *own = [own[0].min(value), own[1].max(value)];
            }
        }
        let mut lines = vec![
            fact("kind", "a groom: what is painted on an object", "groom"),
            fact("object", groom.object.clone(), &groom.object),
            fact("voxels", format!("{side} x {side} x {side}"), [side; 3]),
            fact("painted", format!("{} % of the voxels", 100 * painted / all), painted as f64 / all as f64),
        ];
        let channels = ["length", "density", "color", "direction", "amount"].into_iter().zip(ends);
        lines.extend(channels.map(|(name, [low, high])| {
            fact(name, format!("{} to {}", short(low.into()), short(high.into())), [low, high])
        }));
        let notes = groom.odd_values();
        if !notes.is_empty() {
            lines.push(fact("notes", notes.join("; "), &notes));
        }
        Facts { lines, ..Facts::default() }
    }
}

fn fact(name: &'static str, words: impl Into<String>, value: impl Serialize) -> Fact {
    Fact { name, words: words.into(), value: json!(value) }
}

/// Line about the size in millimeters, and where its unit comes from.
fn print_size(size: Vec3, unit: Option<Unit>, is_file: bool) -> Fact {
    if unit.is_none() && !is_file {
        return fact("print", "without a unit; --scale-to 60mm sets the longest side of a print", Value::Null);
    }
    let sides = size.to_array().map(|side| f64::from(side) * unit.unwrap_or_default().millimeters());
    let from = match unit {
        Some(unit) => format!("the unit of the file is {}", unit.symbol()),
        None => "the file has no unit: taken as mm; --unit or --scale-to changes it".into(),
    };
    fact("print", format!("{} mm, {from}", sides.map(|side| significant(side, 6)).join(" x ")), sides)
}

fn in_words(corners: [DVec3; 2], size: Vec3) -> String {
    let [low, high] = corners.map(|corner| corner.to_array().map(short).join(", "));
    let sides = size.to_array().map(|side| short(side.into())).join(" x ");
    format!("({low}) to ({high}), {sides} world units")
}

/// Shortest decimal that is exact for an f32, else for the f64; with an exponent far from 1.
fn short(number: f64) -> String {
    let is_near = number == 0.0 || (1e-4..1e9).contains(&number.abs());
    match (f64::from(number as f32) == number, is_near) {
        (true, true) => (number as f32).to_string(),
        (true, false) => format!("{:e}", number as f32),
        (false, true) => number.to_string(),
        (false, false) => format!("{number:e}"),
    }
}

fn of_solid(solid: &Solid) -> Facts {
    Facts { lines: vec![fact("kind", format!("a formula: {solid:?}"), "formula")], ..Facts::default() }
}

fn of_mesh(mesh: &Mesh) -> Facts {
    let edges = mesh.edges();
    let (triangles, vertices) = (mesh.triangles.len(), edges.vertices);
    let enclosed = mesh.enclosed();
    let closed = edges.open == 0;
    let mut solid = match (closed, edges.turned, mesh.signed_volume() < 0.0) {
        (true, ..) if enclosed.is_nothing => Mesh::ENCLOSES_NOTHING.into(),
        _ if enclosed.is_nothing => {
            format!("open: {} edges have one triangle; {}", edges.open, Mesh::ENCLOSES_NOTHING)
        }
        (false, ..) => format!("open: {} edges have one triangle; holes are closed by the winding number", edges.open),
        (_, 1.., _) => format!("closed, but at {} edges the triangles disagree; they are turned", edges.turned),
        (_, _, true) => "closed, inside out: it is taken as solid either way".into(),
        _ => "closed".into(),
    };
    if enclosed.repeated > 0 {
        solid += &format!("; {} triangles repeat others and count once", enclosed.repeated);
    }
    let kind = if enclosed.is_nothing {
        "nothing"
    } else if closed {
        "closed"
    } else {
        "open"
    };
    let lines = vec![
        fact("kind", "a mesh", "mesh"),
        fact("triangles", format!("{triangles}, {vertices} vertices at different places"), triangles),
        fact("vertices", format!("{vertices}"), vertices),
        fact("bodies", format!("{}", edges.bodies), edges.bodies),
        fact("surface", solid, kind),
        fact(
            "edges",
            format!("{} open, {} crowded, {} turned", edges.open, edges.crowded, edges.turned),
            [edges.open, edges.crowded, edges.turned],
        ),
        fact(
            "volume",
            format!(
                "{} cubic world units{}",
                significant(enclosed.volume, 6),
                if closed { "" } else { ", if it were closed" }
            ),
            enclosed.volume,
        ),
    ];
    Facts { lines, ..Facts::default() }
}

/// Tissue above an iso-value in Hounsfield units: fat is at -100, muscle and organs at 10 to 60, bone from 200 on.
fn boundary(iso: f32) -> &'static str {
    match iso {
        ..-150.0 => "skin",
        ..150.0 => "soft tissue",
        _ => "bone",
    }
}

fn of_volume(volume: &Volume) -> Facts {
    let size = volume.size.map(|n| n.to_string()).join(" x ");
    let spacing = volume.spacing();
    let (low, high) = volume.range();
    let content = match volume.content {
        Content::Scalar => "scalars",
        Content::SignedDistance => "signed distances",
        Content::LevelSet => "a level set",
    };
    let spacings = spacing.to_array().map(|side| short(side.into())).join(" x ");
    let mut lines = vec![
        fact("kind", format!("a volume of {content}"), content),
        fact(
            "voxels",
            format!("{size}, spacing {spacings}{}", if volume.is_aligned() { "" } else { ", oblique" }),
            volume.size,
        ),
        fact("steps", format!("{:?}", volume.steps.to_cols_array_2d()), volume.steps.to_cols_array_2d()),
        fact("values", format!("{} to {}", short(low.into()), short(high.into())), [low, high]),
    ];
    if volume.content != Content::Scalar {
        let slope = volume.slope_at_zero();
        let words = slope.map_or("no surface".into(), |slope| {
            format!("{} per world unit at the surface", significant(slope.into(), 4))
        });
        lines.push(fact("slope", format!("{words}; 1 for a distance"), slope));
        return Facts { lines, ..Facts::default() };
    }
    let own_slope = volume.slope_at_zero().filter(|slope| SLOPE.contains(slope));
    if let Some(slope) = own_slope {
        let words = format!("{slope:.3} per world unit at 0, as signed distances have it: if they are, say --distance");
        lines.push(fact("slope", words, slope));
    }
    let histogram = volume.histogram();
    let iso_values = histogram.as_ref().map(Histogram::boundaries).unwrap_or_default();
    let words = match &iso_values[..] {
        [] => format!("no boundary stands out; {} is the middle of the values", 0.5 * low + 0.5 * high),
        isos => {
            let is_ct = AIR.contains(&low);
            let named = |iso: &f32| if is_ct { format!("{iso} ({})", boundary(*iso)) } else { iso.to_string() };
            let units = if is_ct { "; the values are read as Hounsfield units" } else { "" };
            isos.iter().map(named).collect::<Vec<_>>().join(", ") + ": there the values change most" + units
        }
    };
    lines.push(fact("iso-values", words, &iso_values));
    Facts { lines, histogram, iso_values, is_like_distances: own_slope.is_some(), ..Facts::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat3;

    /// A ball of tissue around one of bone in air, minus `offset`; blurred over two voxels.
    fn scan(offset: f32) -> Volume {
        let size = [48; 3];
        let mut volume = Volume {
            size,
            origin: Vec3::splat(-23.5),
            steps: Mat3::IDENTITY,
            values: Vec::new(),
            content: Content::Scalar,
        };
        for index in 0..48 * 48 * 48 {
            let radius = volume.position([index % 48, index / 48 % 48, index / 2304]).length();
            let step = |at: f32| 0.5 - 0.5 * ((radius - at) / 1.2).clamp(-1.0, 1.0);
            volume.values.push(1040.0 * step(19.0) + 960.0 * step(11.0) - offset);
        }
        volume
    }

    #[test]
    fn only_hounsfield_boundaries_have_names() {
        let words =
            |offset| of_volume(&scan(offset)).lines.into_iter().find(|line| line.name == "iso-values").unwrap().words;
        let ct = words(1000.0);
        let [skin, bone] = ["(skin), ", "(bone): "].map(|name| ct.find(name).unwrap_or_else(|| panic!("{ct}")));
        assert!(skin < bone && ct.ends_with("Hounsfield units"), "{ct}");
        let shifted = words(0.0);
        assert!(!shifted.contains("skin") && !shifted.contains("Hounsfield"), "{shifted}");
    }
}
