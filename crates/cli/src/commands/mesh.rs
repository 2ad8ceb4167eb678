//! `mesh`: the surface of a hypertextured object, as a file.

use super::convert::MESH_ENDS;
use crate::arguments::{ObjectFlags, SceneArguments, Times};
use crate::session::{CheckedScene, FrameObject, Outputs, Preparation, Prepared, say_fault};
use crate::terminal::{absolute, say, with_progress};
use clap::Args;
use glam::Vec3;
use hypertexture::output::PROGRAM;
use hypertexture::render::variant::Variant;
use hypertexture::render::{
    Millimeters, PolygonizeError, Polygons, Subject, UnitOrigin, polygonize, polygonize_with_looks,
};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture::shape::{self, Body, Looks, MeshFormat, PrintBody, PrintFile, Unit};
use hypertexture_support::{significant, write_whole};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Arguments of `mesh`.
#[derive(Args)]
pub struct Mesh {
    /// An object, a scene file, an example scene, or a picture of this program.
    pub input: String,
    /// Output: .stl, .ply, .obj, .glb or .3mf; in millimeters, GLB in meters, if the object has a unit.
    #[arg(long, short, default_value = "mesh.stl", value_name = "FILE")]
    pub output: PathBuf,
    /// The density of the surface, above 0, up to 1.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true)]
    pub density: f32,
    /// Samples along the longest side of the mesh, 8 to 512.
    #[arg(long, default_value_t = 128)]
    pub grid: u32,
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

/// Part of the largest body below which a body is called a speck.
const SPECK: f64 = 1e-3;

/// Polygonizes the surface and writes it.
pub(crate) fn run(command: &Mesh, quiet: bool) -> Result<(), Box<dyn Error>> {
    command.format()?;
    let scene = command.arguments.scene_and_base(&command.input, &command.object)?;
    export(command, CheckedScene::of(scene)?, quiet)
}

impl Mesh {
    fn format(&self) -> Result<MeshFormat, String> {
        let path = &self.output;
        let known = MeshFormat::from_path(path);
        known.ok_or_else(|| format!("--output {}: end the name in {MESH_ENDS}", path.display()))
    }
}

/// Polygonizes the surface of a checked scene and writes it.
pub(crate) fn export(command: &Mesh, scene: CheckedScene, quiet: bool) -> Result<(), Box<dyn Error>> {
    let format = command.format()?;
    let scenes = command.times.scenes(&scene.moving, &command.output)?;
    let outputs = &Outputs::Files(scenes.iter().map(|(_, path)| ("--output", path.clone())).collect());
    let input = command.input.as_str();
    let preparation = Preparation { input, outputs, device: None, serves_all_moments: false, quiet };
    let Prepared { moving, variant, library, subject, fault, .. } = scene.prepare(&preparation)?;
    if moving.camera.clip.is_some() {
        ::log::warn!("camera.clip cuts pictures; the mesh is whole");
    }
    let mut object = FrameObject::of(&variant, &subject);
    for (scene, path) in &scenes {
        object.serve(&Variant::of(scene, &library)?, &library)?;
        write(command, &library, scene, &object.subject, &MeshFile { format, path }, quiet)?;
    }
    if !quiet {
        say_fault(fault);
    }
    Ok(())
}

/// The file of a mesh.
struct MeshFile<'a> {
    format: MeshFormat,
    path: &'a Path,
}

/// Polygonizes a frame and writes it.
fn write(
    command: &Mesh,
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    file: &MeshFile<'_>,
    quiet: bool,
) -> Result<(), Box<dyn Error>> {
    let MeshFile { format, path } = *file;
    let polygons = Polygons { grid: command.grid, density: command.density };
    let made = with_progress(quiet, "mesh", |progress| match format {
        MeshFormat::Stl => Ok((polygonize(library, scene, subject, polygons, progress)?, None)),
        _ => {
            polygonize_with_looks(library, scene, subject, polygons, progress).map(|(mesh, looks)| (mesh, Some(looks)))
        }
    });
    let (mesh, looks) = made.map_err(|error| match error {
        PolygonizeError::Grid(_) | PolygonizeError::Density(_) => format!("--{error}").into(),
        error => Box::<dyn Error>::from(error),
    })?;
    let (mut mesh, mut looks) = (mesh, looks);
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
    let (millimeters, world) = (subject.millimeters(&scene.object), mesh.signed_volume());
    let size = mesh.bounds().max - mesh.bounds().min;
    let mesh = mesh.scaled(factor(format, millimeters));
    let bytes = encoded(format, command, &mesh, looks.as_ref())?;
    write_whole(path, &bytes).map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    if !quiet {
        let edges = mesh.edges();
        say(&format!(
            "mesh       {} vertices, {} triangles, {}; {}\n\
             size       {} x {} x {}, volume {} cubic world units\n{}{}wrote {}\n",
            edges.vertices,
            mesh.triangles.len(),
            if edges.bodies == 1 { "1 body".into() } else { format!("{} bodies", edges.bodies) },
            if edges.open + edges.crowded + edges.turned == 0 { "watertight" } else { "not watertight" },
            size.x,
            size.y,
            size.z,
            world,
            specks(&bodies, dropped),
            print_size(format, size, millimeters),
            absolute(path)
        ));
    }
    Ok(())
}

/// Line about bodies, by falling volume, that are small beside the largest, or were dropped.
fn specks(bodies: &[Body], dropped: usize) -> String {
    let least = SPECK * bodies.first().map_or(0.0, |body| body.volume);
    let small: Vec<&Body> = bodies[..bodies.len() - dropped].iter().filter(|body| body.volume < least).collect();
    let gone = if dropped > 0 { format!("{dropped} smaller ones were dropped") } else { String::new() };
    let left = small.first().map(|first| {
        let [x, y, z] = first.place.to_array().map(|part| significant(f64::from(part), 3));
        let (count, volume) = (small.len(), significant(first.volume, 3));
        format!(
            "{count} below 0.1% of the volume of the largest, of up to {volume} (at {x}, {y}, {z}); --smallest 0.1% drops them"
        )
    });
    let all: Vec<String> = [gone].into_iter().filter(|text| !text.is_empty()).chain(left).collect();
    if all.is_empty() { String::new() } else { format!("bodies     {}\n", all.join("; ")) }
}

/// Unit of written coordinates in world units: millimeters, for GLB meters; world units of an object without a unit.
fn factor(format: MeshFormat, millimeters: Option<Millimeters>) -> f64 {
    match (format, millimeters) {
        (_, None | Some(Millimeters { from: UnitOrigin::Assumed, .. })) => 1.0,
        (MeshFormat::Glb, Some(size)) => size.per_world_unit / Unit::Meter.millimeters(),
        (_, Some(size)) => size.per_world_unit,
    }
}

/// The bytes of a file; one body of 3MF is named after the object.
fn encoded(
    format: MeshFormat,
    command: &Mesh,
    mesh: &shape::Mesh,
    looks: Option<&Looks>,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = Vec::new();
    if format != MeshFormat::ThreeMf {
        format.write_with(mesh, looks, &mut bytes)?;
        return Ok(bytes);
    }
    let name = Path::new(&command.input).file_stem().unwrap_or_default().to_string_lossy();
    let metadata = [("Title".into(), name.clone().into_owned()), ("Application".into(), PROGRAM.into())];
    let bodies = &[PrintBody { name: &name, mesh, looks }];
    PrintFile { bodies, metadata: &metadata, ..PrintFile::default() }.write(&mut bytes)?;
    Ok(bytes)
}

/// Line about the size of a print.
fn print_size(format: MeshFormat, size: Vec3, millimeters: Option<Millimeters>) -> String {
    let per_unit = millimeters.map_or(1.0, |size| size.per_world_unit);
    let [x, y, z] = size.to_array().map(|side| significant(f64::from(side) * per_unit, 3));
    let why = match (millimeters, format) {
        (Some(size), _) => size.from.words(),
        (None, MeshFormat::Stl | MeshFormat::Obj | MeshFormat::ThreeMf) => {
            "as slicers read it; --scale-to 60mm sets the longest side of the object".into()
        }
        (None, _) => return String::new(),
    };
    format!("print      {x} x {y} x {z} mm, {why}\n")
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
    fn meshes_are_written_in_millimeters_where_the_unit_is_known() {
        let size = |from| Some(Millimeters { per_object_unit: 30.0, per_world_unit: 20.0, from });
        assert_eq!(factor(MeshFormat::Stl, size(UnitOrigin::ScaleTo)), 20.0);
        assert_eq!(factor(MeshFormat::Glb, size(UnitOrigin::File(Unit::Meter))), 0.02);
        assert_eq!((factor(MeshFormat::Ply, size(UnitOrigin::Assumed)), factor(MeshFormat::ThreeMf, None)), (1.0, 1.0));
        let line = print_size(MeshFormat::Ply, Vec3::new(3.0, 2.0, 1.0), size(UnitOrigin::ScaleTo));
        assert_eq!(line, "print      60 x 40 x 20 mm, by --scale-to\n");
    }

    #[test]
    fn specks_are_counted_beside_the_largest() {
        let body = |volume| Body { volume, triangles: 4, place: Vec3::new(1.0, 2.0, 3.0) };
        let all = [body(2.0), body(0.5), body(1e-4), body(1e-9)];
        assert_eq!(specks(&all[..2], 0), "");
        assert!(
            specks(&all, 0)
                .starts_with("bodies     2 below 0.1% of the volume of the largest, of up to 0.0001 (at 1, 2, 3)")
        );
        assert_eq!(specks(&all, 2), "bodies     2 smaller ones were dropped\n");
    }
}
