//! `mesh`: the surface of a hypertextured object, as a file.

mod file;
mod report;

use super::convert::MESH_ENDS;
use crate::arguments::{ObjectFlags, SceneArguments, Times};
use crate::session::{CheckedScene, FrameObject, Outputs, Preparation, Prepared, say_fault};
use crate::terminal::{absolute, say, say_json, with_progress};
use clap::Args;
use file::{Bodies, encoded, factor, stand};
use glam::DVec3;
use hypertexture::render::variant::Variant;
use hypertexture::render::{
    Detail, Millimeters, PolygonizeError, Polygons, Proof, SolidError, SolidFacts, Subject, polygonize,
    polygonize_with_looks, solid,
};
use hypertexture::scene::{Length, Scene};
use hypertexture::shader::Library;
use hypertexture::shape::{self, Looks, MeshFormat};
use hypertexture_support::{significant, write_whole};
use report::{Report, SolidReport};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Arguments of `mesh`.
#[derive(Args)]
pub struct Mesh {
    /// An object, a scene file, an example scene, or a picture of this program.
    pub input: String,
    /// Output: .stl, .ply, .obj, .glb or .3mf.
    ///
    /// Lengths are in millimeters, those of GLB in meters, if the object has a unit.
    #[arg(long, short, default_value = "mesh.stl", value_name = "FILE")]
    pub output: PathBuf,
    /// The density of the surface, above 0, up to 1.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true)]
    pub density: f32,
    /// Samples along the longest side of the mesh, 8 to 512.
    #[arg(long, default_value_t = 128)]
    pub grid: u32,
    /// Most distance from the surface, as 0.05mm or in world units; proven.
    ///
    /// The mesh has as few triangles as it takes.
    #[arg(long, value_name = "LENGTH", value_parser = tolerance, conflicts_with = "grid")]
    pub tolerance: Option<Tolerance>,
    /// Most triangles, 100 to 10000000; the distance is proven and told.
    #[arg(long, value_name = "NUMBER", conflicts_with_all = ["grid", "tolerance"])]
    pub triangles: Option<usize>,
    /// Bodies of a 3MF file.
    #[arg(long, value_enum, default_value_t, hide_short_help = true)]
    pub bodies: Bodies,
    /// Print the facts as JSON.
    #[arg(long)]
    pub json: bool,
    /// Drop bodies whose volume is less: cubic world units, or a part of the largest, as 0.1%.
    #[arg(long, value_name = "VOLUME_OR_FRACTION", value_parser = smallest, hide_short_help = true)]
    pub smallest: Option<Smallest>,
    /// The frames.
    #[command(flatten)]
    pub times: Times,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Least volume of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Smallest {
    /// Cubic world units.
    Volume(f64),
    /// A part of the volume of the largest body.
    Fraction(f64),
}

/// Distance of a mesh from its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// Millimeters.
    Millimeters(f64),
    /// World units.
    World(f64),
}

fn tolerance(text: &str) -> Result<Tolerance, String> {
    let found = match Length::parse(text) {
        Some(Length(millimeters)) => Some(Tolerance::Millimeters(millimeters)),
        None => text.trim().parse().ok().map(Tolerance::World),
    };
    let is_length = |found: &Tolerance| {
        let (Tolerance::Millimeters(length) | Tolerance::World(length)) = *found;
        length.is_finite() && length > 0.0
    };
    found.filter(is_length).ok_or_else(|| "write a length above 0, such as 0.05mm, or a number of world units".into())
}

impl Smallest {
    /// The volume in cubic world units.
    fn of(self, largest: f64) -> f64 {
        match self {
            Smallest::Volume(volume) => volume,
            Smallest::Fraction(fraction) => fraction * largest,
        }
    }
}

fn smallest(text: &str) -> Result<Smallest, String> {
    let (number, is_part) = text.trim().strip_suffix('%').map_or((text.trim(), false), |number| (number, true));
    match number.trim().parse::<f64>() {
        Ok(percent) if is_part && (0.0..=100.0).contains(&percent) => Ok(Smallest::Fraction(0.01 * percent)),
        Ok(volume) if !is_part && volume >= 0.0 && volume.is_finite() => Ok(Smallest::Volume(volume)),
        _ => {
            Err("write a volume in cubic world units, such as 0.002, or a part of the largest body, such as 0.1%"
                .into())
        }
    }
}

/// Polygonizes the surface and writes it.
pub(crate) fn run(command: &Mesh, quiet: bool) -> Result<(), Box<dyn Error>> {
    command.format()?;
    let scene = command.arguments.scene_and_base(&command.input, &command.object)?;
    export(command, CheckedScene::of(scene)?, quiet).map(drop)
}

impl Mesh {
    fn format(&self) -> Result<MeshFormat, String> {
        let path = &self.output;
        let known = MeshFormat::from_path(path);
        let format = known.ok_or_else(|| format!("--output {}: end the name in {MESH_ENDS}", path.display()))?;
        if self.bodies == Bodies::Apart && format != MeshFormat::ThreeMf {
            return Err(format!("--bodies apart: only .3mf has bodies, and --output is {}", path.display()));
        }
        Ok(format)
    }
}

/// Polygonizes the surface of a checked scene and writes it. Returns lines about the last file.
pub(crate) fn export(command: &Mesh, scene: CheckedScene, quiet: bool) -> Result<String, Box<dyn Error>> {
    let format = command.format()?;
    let scenes = command.times.scenes(&scene.moving, &command.output)?;
    let outputs = &Outputs::Files(scenes.iter().map(|(_, path)| ("--output", path.clone())).collect());
    let input = command.input.as_str();
    let preparation = Preparation { input, outputs, device: None, serves_all_moments: false, quiet };
    let Prepared { moving, variant, library, subject, fault, .. } = scene.prepare(&preparation)?;
    if moving.camera.clip.is_some() {
        ::log::warn!("camera.clip cuts pictures; the mesh is whole");
    }
    let (mut object, mut lines) = (FrameObject::of(&variant, &subject), String::new());
    for (scene, path) in &scenes {
        object.serve(&Variant::of(scene, &library)?, &library)?;
        lines = write(command, &library, scene, &object.subject, &MeshFile { format, path }, quiet)?;
    }
    if !quiet {
        say_fault(fault);
    }
    Ok(lines)
}

/// The file of a mesh.
struct MeshFile<'a> {
    format: MeshFormat,
    path: &'a Path,
}

/// A mesh with its facts.
struct Made {
    mesh: shape::Mesh,
    looks: Option<Looks>,
    /// Proof, and triangles before decimation, of a mesh that is held to a tolerance or a number of triangles.
    proof: Option<(Proof, usize)>,
}

impl Made {
    /// Makes the mesh of a frame; STL needs no colors.
    fn of(
        command: &Mesh,
        (library, scene, subject): (&Library, &Scene, &Subject),
        format: MeshFormat,
        quiet: bool,
    ) -> Result<Made, Box<dyn Error>> {
        let size = subject.millimeters(&scene.object);
        if let Some(detail) = command.detail(scene, size)? {
            let made = with_progress(quiet, "mesh", |progress| {
                solid(library, scene, subject, (command.density, detail), progress)
            });
            let made = made.map_err(|error| in_millimeters(command, error, size))?;
            return Ok(Made { mesh: made.mesh, looks: Some(made.looks), proof: Some((made.proof, made.full)) });
        }
        let polygons = Polygons { grid: command.grid, density: command.density };
        let made = with_progress(quiet, "mesh", |progress| match format {
            MeshFormat::Stl => Ok((polygonize(library, scene, subject, polygons, progress)?, None)),
            _ => polygonize_with_looks(library, scene, subject, polygons, progress)
                .map(|(mesh, looks)| (mesh, Some(looks))),
        });
        let (mesh, looks) = made.map_err(flagged)?;
        Ok(Made { mesh, looks, proof: None })
    }
}

/// An error of a setting with its flag.
fn flagged(error: PolygonizeError) -> Box<dyn Error> {
    match error {
        PolygonizeError::Grid(_) | PolygonizeError::Density(_) => format!("--{error}").into(),
        error => error.into(),
    }
}

/// An error with its flag, and lengths in the unit of the command.
fn in_millimeters(command: &Mesh, error: SolidError, size: Option<Millimeters>) -> Box<dyn Error> {
    let (unit, symbol) = match (command.tolerance, size) {
        (Some(Tolerance::Millimeters(_)), Some(size)) => (size.per_world_unit, " mm"),
        _ => (1.0, ""),
    };
    let length = |length: f64| format!("{}{symbol}", significant(length * unit, 3));
    match error {
        SolidError::Tolerance { tolerance, least, most } => format!(
            "--tolerance {}: not from {} to {}, which this object allows",
            length(tolerance),
            length(least),
            length(most)
        )
        .into(),
        SolidError::Memory { tolerance, needed, most, fits } => format!(
            "--tolerance {}: needs about {} MiB of memory, and {} MiB may be used; {} fits",
            length(tolerance),
            needed >> 20,
            most >> 20,
            length(fits)
        )
        .into(),
        SolidError::Polygonize(error) => flagged(error),
        error @ SolidError::Triangles(_) => format!("--{error}").into(),
    }
}

impl Mesh {
    /// Tolerance or number of triangles; `None` for a grid.
    fn detail(&self, scene: &Scene, size: Option<Millimeters>) -> Result<Option<Detail>, String> {
        Ok(match (self.tolerance, self.triangles) {
            (Some(Tolerance::World(length)), _) => Some(Detail::Tolerance(length)),
            (Some(Tolerance::Millimeters(length)), _) => {
                let size = size.ok_or_else(|| {
                    format!(
                        "--tolerance {length}mm: {} has no unit; give its longest side, such as --scale-to 60mm",
                        scene.object.input
                    )
                })?;
                Some(Detail::Tolerance(length / size.per_world_unit))
            }
            (None, Some(count)) => Some(Detail::Triangles(count)),
            (None, None) => None,
        })
    }
}

/// Polygonizes a frame and writes it. Returns lines about the file.
fn write(
    command: &Mesh,
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    file: &MeshFile<'_>,
    quiet: bool,
) -> Result<String, Box<dyn Error>> {
    let MeshFile { format, path } = *file;
    let Made { mut mesh, mut looks, proof } = Made::of(command, (library, scene, subject), format, quiet)?;
    let stands = format == MeshFormat::ThreeMf && stand(&mut mesh, looks.as_mut(), &scene.object);
    let bodies = mesh.bodies();
    let largest = bodies.first().map_or(0.0, |body| body.volume);
    let mut dropped = 0;
    if let Some(smallest) = command.smallest {
        let least = smallest.of(largest);
        dropped = bodies.iter().filter(|body| body.volume < least).count();
        if dropped == bodies.len() {
            return Err(format!(
                "--smallest: the largest of {dropped} bodies has a volume of {}, and none would be left; lower it",
                significant(largest, 4)
            )
            .into());
        }
        if dropped > 0 {
            mesh = mesh.without_bodies_below(least, looks.as_mut());
        }
    }
    let mut report = Report::of(&mesh, bodies, dropped);
    report.millimeters = subject.millimeters(&scene.object);
    report.solid = proof.map(|(proof, full)| {
        let up = if stands { DVec3::Z } else { scene.object.up.turned_back(DVec3::Y) };
        let facts = SolidFacts::of(&mesh, up);
        SolidReport { proof, full, facts }
    });
    let mesh = mesh.scaled(factor(format, report.millimeters));
    let name = Path::new(&command.input).file_stem().unwrap_or_default().to_string_lossy();
    let bytes = encoded(format, (&name, command.bodies), (&mesh, looks.as_ref()), &report)?;
    write_whole(path, &bytes).map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    let lines = report.lines(format);
    if command.json {
        let mut facts = report.json();
        facts["file"] = absolute(path).to_string().into();
        say_json(&facts)?;
    } else if !quiet {
        say(&format!("{lines}wrote {}\n", absolute(path)));
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_least_body_is_a_volume_or_a_part() {
        assert_eq!(smallest("0.002"), Ok(Smallest::Volume(0.002)));
        assert_eq!(smallest("50 %").map(|smallest| smallest.of(4.0)), Ok(2.0));
        assert!(["-1", "x", "101%", "nan", "inf", "%", ""].iter().all(|text| smallest(text).is_err()));
    }

    #[test]
    fn a_tolerance_is_a_length_or_a_number_of_units() {
        assert_eq!(tolerance("0.05mm"), Ok(Tolerance::Millimeters(0.05)));
        assert_eq!(tolerance("0.5 cm"), Ok(Tolerance::Millimeters(5.0)));
        assert_eq!(tolerance("0.01"), Ok(Tolerance::World(0.01)));
        assert!(["0", "-1mm", "nan", "1 px", ""].iter().all(|text| tolerance(text).is_err()));
    }
}
