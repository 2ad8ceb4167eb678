//! Writers of volumes.
//!
//! Invariant: a volume is read back bit for bit, except from NPY.

use super::values::{LEVEL, check, write_values};
use super::{nifti, vdb};
use crate::shape::axes::{directions, lengths};
use crate::shape::{Content, Volume};
use crate::volume::space::{Space, listed};
use crate::volume::{meta, nrrd};
use flate2::write::{GzEncoder, ZlibEncoder};
use glam::{Mat3, Vec3};
use std::io::{self, Write};
use std::path::Path;

/// File format of written volumes: 32-bit floats, little endian, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VolumeFormat {
    /// NRRD in one file, gzip. A signed distance is marked by the line `hypertexture content:=signed distance`.
    Nrrd,
    /// MetaImage in one file, zlib. A signed distance is marked by its comment.
    MetaImage,
    /// NIfTI-1, or NIfTI-2 where a side is longer than 32767 samples. A signed distance is marked by its description.
    Nifti,
    /// [`VolumeFormat::Nifti`] in gzip.
    NiftiGzip,
    /// OpenVDB with one grid in zip: `surface` of class `level set` for distances, else `density` of class `fog volume`. The
    /// background is the largest distance, or the first value. A nearly empty file is not read back above 2^26 voxels.
    OpenVdb,
    /// NumPy array of shape (z, y, x), without placement and meaning.
    Npy,
}

impl VolumeFormat {
    const ENDS: [(VolumeFormat, &'static str); 6] = [
        (VolumeFormat::Nrrd, ".nrrd"),
        (VolumeFormat::MetaImage, ".mha"),
        (VolumeFormat::Nifti, ".nii"),
        (VolumeFormat::NiftiGzip, ".nii.gz"),
        (VolumeFormat::OpenVdb, ".vdb"),
        (VolumeFormat::Npy, ".npy"),
    ];

    /// Format by extension: .nrrd, .mha, .nii, .nii.gz, .vdb or .npy, in any case.
    pub fn from_path(path: &Path) -> Option<VolumeFormat> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        VolumeFormat::ENDS.iter().find(|(_, end)| name.ends_with(end)).map(|(format, _)| *format)
    }

    /// The place of a volume in words, if the format does not keep it: its first sample and its steps.
    pub fn lost_place(self, origin: Vec3, steps: Mat3) -> Option<String> {
        let is_lost = self == VolumeFormat::Npy && (origin, steps) != (Vec3::ZERO, Mat3::IDENTITY);
        is_lost.then(|| {
            let [x, y, z] = steps.to_cols_array_2d();
            let spacing = [x[0], y[1], z[2]];
            let steps = if steps == Mat3::from_diagonal(spacing.into()) {
                format!("spacing {spacing:?}")
            } else {
                format!("steps {x:?}, {y:?}, {z:?}")
            };
            format!("not in the file: origin {:?}, {steps}, world units", origin.to_array())
        })
    }

    /// Writes a volume. [`open`](crate::open) reads it back bit for bit, except from [`VolumeFormat::Npy`], if the values are
    /// finite and the samples within 131072 voxels of the origin. World axes that are permuted or reversed come back in order.
    ///
    /// # Errors
    /// Errors of `to`, and `InvalidInput` if the number of values is not the product of the sizes.
    pub fn write(&self, volume: &Volume, mut to: impl Write) -> io::Result<()> {
        check(volume)?;
        match self {
            VolumeFormat::Nrrd => write_nrrd(volume, to),
            VolumeFormat::MetaImage => write_meta(volume, to),
            VolumeFormat::Nifti => {
                nifti::write(volume, &mut to)?;
                to.flush()
            }
            VolumeFormat::NiftiGzip => {
                let mut encoder = GzEncoder::new(to, LEVEL);
                nifti::write(volume, &mut encoder)?;
                encoder.finish()?.flush()
            }
            VolumeFormat::OpenVdb => {
                vdb::write(volume, &mut to)?;
                to.flush()
            }
            VolumeFormat::Npy => {
                let [x, y, z] = volume.size;
                let about = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({z}, {y}, {x}), }}");
                let length = (10 + about.len() + 1).next_multiple_of(64) - 10;
                to.write_all(b"\x93NUMPY\x01\0")?;
                to.write_all(&(length as u16).to_le_bytes())?;
                writeln!(to, "{about:<width$}", width = length - 1)?;
                write_values(volume, &mut to)?;
                to.flush()
            }
        }
    }
}

fn write_nrrd(volume: &Volume, mut to: impl Write) -> io::Result<()> {
    let ([x, y, z], steps, origin) = (volume.size, volume.steps, volume.origin);
    writeln!(to, "NRRD0005\n# written by hypertexture\ntype: float\ndimension: 3\nspace: right-anterior-superior")?;
    writeln!(to, "sizes: {x} {y} {z}")?;
    let [a, b, c] =
        [steps.x_axis, steps.y_axis, steps.z_axis].map(|step| format!("({},{},{})", step.x, step.y, step.z));
    writeln!(to, "space directions: {a} {b} {c}")?;
    writeln!(to, "space origin: ({},{},{})", origin.x, origin.y, origin.z)?;
    writeln!(to, "kinds: domain domain domain\nendian: little\nencoding: gzip")?;
    if volume.content == Content::SignedDistance {
        writeln!(to, "{}:={}", nrrd::CONTENT_KEY, nrrd::SIGNED_DISTANCE)?;
    }
    writeln!(to)?;
    let mut encoder = GzEncoder::new(to, LEVEL);
    write_values(volume, &mut encoder)?;
    encoder.finish()?.flush()
}

fn write_meta(volume: &Volume, mut to: impl Write) -> io::Result<()> {
    let [x, y, z] = volume.size;
    // The conversion to LPS is its own inverse.
    let origin = Space::LPS.position(volume.origin.as_dvec3());
    let steps = Space::LPS.steps(&volume.steps.as_dmat3());
    writeln!(to, "ObjectType = Image\nNDims = 3")?;
    if volume.content == Content::SignedDistance {
        writeln!(to, "Comment = {}", meta::SIGNED_DISTANCE)?;
    }
    // The header holds the compressed length.
    let mut encoder = ZlibEncoder::new(Vec::new(), LEVEL);
    write_values(volume, &mut encoder)?;
    let data = encoder.finish()?;
    writeln!(to, "BinaryData = True\nBinaryDataByteOrderMSB = False")?;
    writeln!(to, "CompressedData = True\nCompressedDataSize = {}", data.len())?;
    writeln!(to, "TransformMatrix = {}", listed(&directions(&steps).to_cols_array()))?;
    writeln!(to, "Offset = {}", listed(&origin.to_array()))?;
    writeln!(to, "CenterOfRotation = 0 0 0\nElementSpacing = {}", listed(&lengths(&steps).to_array()))?;
    writeln!(to, "DimSize = {x} {y} {z}\nElementType = MET_FLOAT\nElementDataFile = LOCAL")?;
    to.write_all(&data)?;
    to.flush()
}
