//! `convert`: a volume or a mesh in another format, and values without a header as a volume.

use crate::terminal::{absolute, say};
use clap::Args;
use hypertexture::output;
use hypertexture::shape::{self, Looks, MeshFormat, Opened, RawLayout, SampleType, Shape, Unit, VolumeFormat};
use hypertexture_support::write_whole;
use std::error::Error;
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Args)]
pub(crate) struct Convert {
    /// A volume or a mesh that `render` takes, or values without a header.
    pub input: String,
    /// The grid of an OpenVDB file with several.
    #[arg(long, value_name = "NAME", conflicts_with = "dims")]
    pub grid: Option<String>,
    /// Output: .nrrd, .mha, .nii, .nii.gz, .vdb or .npy.
    ///
    /// Of a mesh .stl, .ply, .obj, .glb or .3mf, which is in millimeters by the unit of the input.
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// Number of values along x, y and z, x fastest, of a file without a header.
    #[arg(long, value_delimiter = ',', value_name = "X,Y,Z")]
    pub dims: Option<Vec<u32>>,
    /// Type of values without a header.
    ///
    /// One of uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32 and float64.
    #[arg(long = "type", requires = "dims", value_name = "TYPE")]
    pub kind: Option<SampleType>,
    /// Byte order of the values.
    #[arg(long, requires = "dims", value_parser = ["little", "big"], default_value = "little")]
    pub endian: String,
    /// Distance of neighboring values along x, y and z, world units.
    #[arg(long, requires = "dims", value_delimiter = ',', value_name = "X,Y,Z")]
    pub spacing: Option<Vec<f64>>,
    /// Bytes before the first value [default: the values end the file].
    #[arg(long, requires = "dims", value_name = "BYTES")]
    pub skip: Option<u64>,
}

/// Converts a file.
pub(crate) fn run(command: &Convert, quiet: bool) -> Result<(), Box<dyn Error>> {
    let path = &command.output;
    let (volume, mesh) = (VolumeFormat::from_path(path), MeshFormat::from_path(path));
    if volume.is_none() && mesh.is_none() {
        return Err(format!("--output {}: end the name in {ENDS}, or of a mesh in {MESH_ENDS}", path.display()).into());
    }
    output::check_all([("--output", path.clone())], [PathBuf::from(&command.input)])?;
    let mut unit = None;
    let mut shape = match &command.dims {
        Some(dims) => {
            let size = three(dims).ok_or("--dims: give 3 numbers, such as 256,256,128")?;
            let kind = command.kind.ok_or("--dims: say the type of the values too, such as --type uint16")?;
            let spacing = match &command.spacing {
                Some(spacing) => three(spacing).ok_or("--spacing: give 3 numbers, such as 0.5,0.5,2")?,
                None => [1.0; 3],
            };
            let big_endian = command.endian == "big";
            let layout = RawLayout { size, kind, big_endian, spacing, skip: command.skip };
            shape::open_raw(&command.input, &layout)?
        }
        None => {
            let (input, grid) = (&command.input, command.grid.as_deref());
            let opened = match mesh.map(|_| Opened::with_paint(input, grid)) {
                Some(Ok(opened)) => opened,
                // Colors alone may be the fault.
                Some(Err(error)) => {
                    let plain = Opened::with_grid(input, grid)?;
                    ::log::warn!("colors of materials are left out: {error}");
                    plain
                }
                None => Opened::with_grid(input, grid)?,
            };
            output::check_all([("--output", path.clone())], opened.others.clone())?;
            unit = opened.unit;
            opened.warned(&command.input)
        }
    };
    // 3MF is written in millimeters, glTF has meters; other formats have no unit.
    if let (Shape::Mesh(mesh), Some(format @ (MeshFormat::ThreeMf | MeshFormat::Glb)), Some(unit)) =
        (&mut shape, mesh, unit)
    {
        let own = if format == MeshFormat::Glb { Unit::Meter } else { Unit::Millimeter };
        *mesh = std::mem::take(mesh).scaled(unit.millimeters() / own.millimeters());
    }
    let (input, mut bytes) = (&command.input, Vec::new());
    let about = match (&shape, volume, mesh) {
        (Shape::Volume(volume), Some(format), _) => {
            format.write(volume, &mut bytes)?;
            let (low, high) = volume.range();
            let place = format.lost_place(volume.origin, volume.steps);
            let place = place.map_or(String::new(), |place| format!("\nplace      {place}"));
            format!("volume     {}, values {low} to {high}{place}", volume.size.map(|n| n.to_string()).join(" x "))
        }
        (Shape::Mesh(mesh), _, Some(format)) => {
            let colors = mesh.vertex_colors();
            let colored = match (colors.is_empty(), format.has_colors()) {
                (true, _) => "",
                (false, false) => "; STL has no colors, those of the mesh are left out",
                (false, true) if mesh.paint.is_textured() => "; textures become colors of vertices",
                (false, true) => ", with colors of vertices",
            };
            let looks = (!colors.is_empty()).then(|| Looks { normals: Vec::new(), colors });
            format.write_with(mesh, looks.as_ref(), &mut bytes)?;
            format!("mesh       {} vertices, {} triangles{colored}", mesh.positions.len(), mesh.triangles.len())
        }
        (_, Some(_), _) => {
            return Err(format!("{input}: not a volume; `hypertexture field {input}` writes its distance field").into());
        }
        _ => return Err(format!("{input}: not a mesh; `hypertexture mesh {input}` writes its surface as one").into()),
    };
    write_whole(path, &bytes).map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    if !quiet {
        say(&format!("{about}\nwrote {}\n", absolute(path)));
    }
    Ok(())
}

/// Exactly three numbers.
fn three<T: Copy>(numbers: &[T]) -> Option<[T; 3]> {
    numbers.try_into().ok()
}

/// Ends of names of meshes that are written.
pub(crate) const MESH_ENDS: &str = ".stl, .ply, .obj, .glb or .3mf";
/// Ends of names of volumes that are written.
pub(crate) const ENDS: &str = ".nrrd, .mha, .nii, .nii.gz, .vdb or .npy";
