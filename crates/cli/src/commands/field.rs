//! `field`: the distance field of an object, as a file.

use super::convert::ENDS;
use crate::arguments::ObjectFlags;
use crate::terminal::{absolute, say, with_progress};
use clap::Args;
use glam::DVec3;
use hypertexture::render::{open, request};
use hypertexture::scene::{Object, Scene};
use hypertexture::shape::{Mesh, Shape, VolumeFormat};
use hypertexture::{field, output};
use hypertexture_support::{significant, write_whole};
use std::error::Error;
use std::path::PathBuf;

/// Arguments of `field`.
#[derive(Args)]
pub struct Field {
    /// A built-in object, a mesh, a scalar volume or a distance field.
    pub input: String,
    /// Output: .nrrd, .mha, .nii, .nii.gz, .vdb or .npy.
    #[arg(long, short, default_value = "field.nrrd", value_name = "FILE")]
    pub output: PathBuf,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// Margin around the object.
    ///
    /// 1 is half of its longest side.
    #[arg(long, default_value_t = 0.25, allow_negative_numbers = true)]
    pub margin: f32,
}

/// Computes and writes the field.
pub(crate) fn run(command: &Field, quiet: bool) -> Result<(), Box<dyn Error>> {
    let known = VolumeFormat::from_path(&command.output);
    let format = known.ok_or_else(|| format!("--output {}: end the name in {ENDS}", command.output.display()))?;
    output::check_all([("--output", command.output.clone())], [PathBuf::from(&command.input)])?;
    let mut scene = Scene { object: Object { input: command.input.clone(), ..Object::default() }, ..Scene::default() };
    command.object.apply(&mut scene)?;
    let object = scene.object;
    if !(0.0..=4.0).contains(&command.margin) {
        return Err(format!(
            "--margin {}: must be from 0 to 4 (1 is half of the object's longest side)",
            command.margin
        )
        .into());
    }
    let shape = open(&object)?;
    let request = request(&shape, &object, command.margin);
    let (field, _, report) =
        with_progress(quiet, "distance field", |progress| field::load_or_compute(&shape, &request, false, progress))?;
    let field = field.turned(object.up.turn());
    let (grid, (low, high)) = (field.grid, field.range());
    let (volume, mut bytes) = (field.into_volume(), Vec::new());
    format.write(&volume, &mut bytes)?;
    write_whole(&command.output, &bytes)
        .map_err(|error| format!("{}: {error}; nothing was written", command.output.display()))?;
    if !quiet {
        let [x, y, z] = grid.size;
        if let Shape::Mesh(Mesh { offset, .. }) = &shape
            && *offset != DVec3::ZERO
        {
            say(&format!("offset     {offset} is its origin in the coordinates of the file\n"));
        }
        if low >= 0.0 {
            say(&format!("inside     no sample: {}\n", without_inside(&shape)));
        }
        let place = format.lost_place(volume.origin, volume.steps);
        let place = place.map_or(String::new(), |place| format!("place      {place}\n"));
        let [low, high, band] = [low, high, request.band].map(|length| significant(length.into(), 5));
        say(&format!(
            "field      {x} x {y} x {z}, spacing {:?}, distances {low} to {high} world units\n{place}\
             exact      within {band} of the surface; a lower bound beyond\n\
             surface    {} triangles, {} open edges, {} closing; {:.0} ms\nwrote {}\n",
            grid.spacing.to_array(),
            report.triangles,
            report.open_edges,
            report.closing_triangles,
            report.ms,
            absolute(&command.output)
        ));
    }
    Ok(())
}

/// Explanation of a field without a sample inside.
fn without_inside(shape: &Shape) -> &'static str {
    match shape {
        Shape::Mesh(mesh) if mesh.enclosed().is_nothing => Mesh::ENCLOSES_NOTHING,
        _ => "its inside is thinner than a voxel; raise --resolution, or give it a thickness (--shell)",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_field_without_inside_says_why() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mut mesh = Mesh { positions, triangles, ..Mesh::default() };
        assert!(without_inside(&Shape::Mesh(mesh.clone())).contains("thinner than a voxel"));
        mesh.triangles.extend(mesh.triangles.clone().iter().map(|&[a, b, c]| [a, c, b]));
        assert_eq!(without_inside(&Shape::Mesh(mesh)), Mesh::ENCLOSES_NOTHING);
    }
}
