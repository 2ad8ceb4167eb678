//! `info`: what a file holds, before anything is made of it.

use super::say;
use crate::shape::{self, Content, Mesh, Shape, Solid, Volume};
use clap::Args;
use glam::{DVec3, Vec3};
use serde::Serialize;
use serde_json::{Value, json};
use std::error::Error;
use std::ops::RangeInclusive;

/// Rows of the histogram.
const ROWS: usize = 16;
/// How much scalars that are distances change per world unit where they are 0.
const SLOPE: RangeInclusive<f32> = 0.95..=1.05;
/// Characters of its longest bar.
const BAR: f64 = 40.0;

/// Arguments of `info`.
#[derive(Args)]
pub struct Info {
    /// A mesh, a volume or a built-in object.
    pub input: String,
    /// Everything as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Reads the file, and says what is in it.
pub(super) fn run(command: &Info) -> Result<(), Box<dyn Error>> {
    let (shape, notes) = shape::open_noted(&command.input)?;
    let (mut facts, offset) = match &shape {
        Shape::Solid(solid) => (of_solid(solid), DVec3::ZERO),
        Shape::Mesh(mesh) => (of_mesh(mesh), mesh.offset),
        Shape::Volume(volume) => (of_volume(volume), DVec3::ZERO),
    };
    if !notes.is_empty() {
        facts.push(fact("ignored", notes.join("; "), &notes));
    }
    let bounds = shape.bounds();
    let corners = [bounds.min, bounds.max].map(|corner| corner.as_dvec3() + offset);
    if command.json {
        let mut all = json!({ "file": command.input, "box": corners.map(|corner| corner.to_array()) });
        let members = facts.iter().map(|fact| (fact.name.to_string(), fact.value.clone()));
        all.as_object_mut().into_iter().for_each(|object| object.extend(members.clone()));
        say(&format!("{}\n", serde_json::to_string_pretty(&all)?));
        return Ok(());
    }
    let mut text: String = facts.iter().map(|fact| format!("{:<11}{}\n", fact.name, fact.words)).collect();
    text += &format!("box        {}\n", in_words(corners, bounds.size()));
    text += &format!("picture    hypertexture render {} -o picture.png{}\n", command.input, surface_flag(&shape));
    say(&text);
    Ok(())
}

/// What is known, in words and for a program.
struct Fact {
    name: &'static str,
    words: String,
    value: Value,
}

fn fact(name: &'static str, words: impl Into<String>, value: impl Serialize) -> Fact {
    Fact { name, words: words.into(), value: json!(value) }
}

fn in_words(corners: [DVec3; 2], size: Vec3) -> String {
    let [low, high] = corners.map(|corner| corner.to_array().map(short).join(", "));
    let sides = size.to_array().map(|side| format!("{side}")).join(" x ");
    format!("({low}) to ({high}), {sides} world units")
}

/// As few digits as tell what was an f32, or all.
fn short(number: f64) -> String {
    if f64::from(number as f32) == number { (number as f32).to_string() } else { number.to_string() }
}

/// The slope at 0 of scalars that change there as distances do.
fn own_slope(volume: &Volume) -> Option<f32> {
    volume.slope_at_zero().filter(|slope| SLOPE.contains(slope))
}

/// The flag that says what the surface of the picture is.
fn surface_flag(shape: &Shape) -> String {
    let first = match shape {
        Shape::Volume(volume) if volume.content == Content::Scalar && own_slope(volume).is_some() => {
            return " --distance".into();
        }
        Shape::Volume(volume) if volume.content == Content::Scalar => volume.iso_values().first().copied(),
        _ => None,
    };
    first.map_or(String::new(), |iso| format!(" --iso {iso}"))
}

fn of_solid(solid: &Solid) -> Vec<Fact> {
    vec![fact("kind", format!("a formula: {solid:?}"), "formula")]
}

fn of_mesh(mesh: &Mesh) -> Vec<Fact> {
    let edges = mesh.edges();
    let (triangles, vertices) = (mesh.triangles.len(), edges.vertices);
    let volume = mesh.signed_volume();
    let closed = edges.open == 0;
    let solid = match (closed, edges.turned, volume < 0.0) {
        (false, ..) => format!("open: {} edges have one triangle; holes are closed by the winding number", edges.open),
        (_, 1.., _) => format!("closed, but at {} edges the triangles disagree; they are turned", edges.turned),
        (_, _, true) => "closed, inside out: it is taken as solid either way".into(),
        _ => "closed".into(),
    };
    vec![
        fact("kind", "a mesh", "mesh"),
        fact("triangles", format!("{triangles}, {vertices} vertices at different places"), triangles),
        fact("vertices", format!("{vertices}"), vertices),
        fact("bodies", format!("{}", edges.bodies), edges.bodies),
        fact("surface", solid, if closed { "closed" } else { "open" }),
        fact(
            "edges",
            format!("{} open, {} crowded, {} turned", edges.open, edges.crowded, edges.turned),
            [edges.open, edges.crowded, edges.turned],
        ),
        fact(
            "volume",
            format!("{volume:.6} cubic world units{}", if closed { "" } else { ", if it were closed" }),
            volume,
        ),
    ]
}

fn of_volume(volume: &Volume) -> Vec<Fact> {
    let size = volume.size.map(|n| n.to_string()).join(" x ");
    let spacing = volume.spacing();
    let (low, high) = volume.range();
    let content = match volume.content {
        Content::Scalar => "scalars",
        Content::SignedDistance => "signed distances",
        Content::LevelSet => "a level set",
    };
    let spacings = spacing.to_array().map(|side| side.to_string()).join(" x ");
    let mut facts = vec![
        fact("kind", format!("a volume of {content}"), content),
        fact(
            "voxels",
            format!("{size}, spacing {spacings}{}", if volume.is_aligned() { "" } else { ", oblique" }),
            volume.size,
        ),
        fact("steps", format!("{:?}", volume.steps.to_cols_array_2d()), volume.steps.to_cols_array_2d()),
        fact("values", format!("{low} to {high}"), [low, high]),
    ];
    if volume.content != Content::Scalar {
        let slope = volume.slope_at_zero();
        let words = slope.map_or("no surface".into(), |slope| format!("{slope:.3} per world unit at the surface"));
        facts.push(fact("slope", format!("{words}; 1 for a distance"), slope));
        return facts;
    }
    if let Some(slope) = own_slope(volume) {
        let words = format!("{slope:.3} per world unit at 0, as signed distances have it: if they are, say --distance");
        facts.push(fact("slope", words, slope));
    }
    let isos = volume.iso_values();
    let words = match &isos[..] {
        [] => format!("no boundary stands out; {} is the middle of the values", 0.5 * (low + high)),
        isos => isos.iter().map(f32::to_string).collect::<Vec<_>>().join(", ") + ": there the values change most",
    };
    facts.push(fact("iso-values", words, &isos));
    if let Some(histogram) = volume.histogram() {
        facts.push(fact(
            "histogram",
            chart(&histogram),
            json!({
                "from": histogram.range.0, "to": histogram.range.1,
                "voxels": histogram.counts, "mean_gradient": histogram.gradients,
            }),
        ));
    }
    facts
}

/// Bars as long as the logarithm of the voxels, and how much the values change there.
fn chart(histogram: &shape::Histogram) -> String {
    let each = histogram.counts.len() / ROWS;
    let (low, high) = histogram.range;
    let rows: Vec<(u64, f64)> = (0..ROWS)
        .map(|row| {
            let own = row * each..(row + 1) * each;
            let count = histogram.counts[own.clone()].iter().sum::<u64>();
            let change = own.map(|bin| histogram.counts[bin] as f64 * histogram.gradients[bin]).sum::<f64>();
            (count, change / count.max(1) as f64)
        })
        .collect();
    let most = rows.iter().map(|(count, _)| *count).max().unwrap_or(1).max(2);
    let line = |(row, (count, change)): (usize, &(u64, f64))| {
        let from = low + (high - low) * row as f32 / ROWS as f32;
        let bar = (((count + 1) as f64).ln() / (most as f64).ln() * BAR).round() as usize;
        format!("\n  {from:>10.4} {:<41} {count}, change {change:.3}", "#".repeat(bar))
    };
    format!(
        "voxels from each value on (logarithmic), and their mean change to the next{}",
        rows.iter().enumerate().map(line).collect::<String>()
    )
}
