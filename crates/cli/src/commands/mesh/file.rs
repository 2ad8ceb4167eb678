//! Files of meshes.

use super::report::Report;
use clap::ValueEnum;
use glam::Vec3;
use hypertexture::output::PROGRAM;
use hypertexture::render::{Millimeters, UnitOrigin};
use hypertexture::scene::{Axis, Object};
use hypertexture::shape::{self, BUILT_IN, Looks, MeshFormat, PrintBody, PrintFile, Unit};
use std::error::Error;

/// Most bodies of a 3MF file that are objects of their own.
const MOST_BODIES: usize = 64;

/// Bodies of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Bodies {
    /// One object.
    #[default]
    Joined,
    /// An object for each body.
    Apart,
}

/// Unit of written coordinates in world units: millimeters, for GLB meters; world units of an object without a unit.
pub(super) fn factor(format: MeshFormat, millimeters: Option<Millimeters>) -> f64 {
    match (format, millimeters) {
        (_, None | Some(Millimeters { from: UnitOrigin::Assumed, .. })) => 1.0,
        (MeshFormat::Glb, Some(size)) => size.per_world_unit / Unit::Meter.millimeters(),
        (_, Some(size)) => size.per_world_unit,
    }
}

/// Turns the mesh of an object without a file, whose y axis is up, so that z is up, as on printers. Returns whether it did.
pub(super) fn stand(mesh: &mut shape::Mesh, looks: Option<&mut Looks>, object: &Object) -> bool {
    let has_own_axes = !object.is_formula() && !BUILT_IN.contains(&&*object.input);
    if object.up != Axis::Y || has_own_axes {
        return false;
    }
    let turn = |[x, y, z]: [f32; 3]| Vec3::new(x, -z, y);
    mesh.positions.iter_mut().for_each(|place| *place = turn(place.to_array()));
    looks.into_iter().flat_map(|looks| &mut looks.normals).for_each(|normal| *normal = turn(normal.to_array()));
    true
}

/// The bytes of a file; bodies of 3MF are named after the object.
pub(super) fn encoded(
    format: MeshFormat,
    (name, bodies): (&str, Bodies),
    (mesh, looks): (&shape::Mesh, Option<&Looks>),
    report: &Report,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = Vec::new();
    if format != MeshFormat::ThreeMf {
        format.write_with(mesh, looks, &mut bytes)?;
        return Ok(bytes);
    }
    let mut metadata = vec![("Title".into(), name.into()), ("Application".into(), PROGRAM.into())];
    metadata.extend(report.statement().map(|statement| ("Description".into(), statement)));
    let parts = match bodies {
        Bodies::Joined => Vec::new(),
        Bodies::Apart => mesh.apart(looks),
    };
    if parts.len() > MOST_BODIES {
        return Err(format!(
            "--bodies apart: {} bodies, and at most {MOST_BODIES} can be objects of their own; --smallest 0.1% drops specks",
            parts.len()
        )
        .into());
    }
    let names: Vec<String> = (1..=parts.len()).map(|number| format!("{name} {number}")).collect();
    let apart = parts.iter().zip(&names).map(|((mesh, looks), name)| PrintBody { name, mesh, looks: looks.as_ref() });
    let mut bodies: Vec<PrintBody<'_>> = apart.collect();
    if bodies.is_empty() {
        bodies.push(PrintBody { name, mesh, looks });
    }
    PrintFile { bodies: &bodies, metadata: &metadata, ..PrintFile::default() }.write(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_written_in_millimeters_where_the_unit_is_known() {
        let size = |from| Some(Millimeters { per_object_unit: 30.0, per_world_unit: 20.0, from });
        assert_eq!(factor(MeshFormat::Stl, size(UnitOrigin::ScaleTo)), 20.0);
        assert_eq!(factor(MeshFormat::Glb, size(UnitOrigin::File(Unit::Meter))), 0.02);
        assert_eq!((factor(MeshFormat::Ply, size(UnitOrigin::Assumed)), factor(MeshFormat::ThreeMf, None)), (1.0, 1.0));
    }

    #[test]
    fn objects_without_a_file_stand_with_z_up() {
        let stood = |input: &str| {
            let mut mesh = shape::Mesh { positions: vec![Vec3::new(1.0, 2.0, 3.0)], ..shape::Mesh::default() };
            let object = Object { input: input.into(), ..Object::default() };
            (stand(&mut mesh, None, &object), mesh.positions[0])
        };
        assert_eq!(stood("teapot"), (true, Vec3::new(1.0, -3.0, 2.0)));
        assert_eq!(stood("teapot.stl"), (false, Vec3::new(1.0, 2.0, 3.0)));
    }
}
