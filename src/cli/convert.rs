//! `convert`: a volume in another format, and values without a header as a volume.

use super::{absolute, say};
use crate::output;
use crate::shape::{self, RawLayout, SampleType, Shape, VolumeFormat};
use crate::support::write_whole;
use clap::Args;
use std::error::Error;
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Args)]
pub struct Convert {
    /// A volume: any that `render` takes, or values without a header and what they are.
    pub input: String,
    /// Where the volume goes: .nrrd, .mha, .nii, .nii.gz or .npy.
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// Values without a header: how many along x, y and z, x fastest.
    #[arg(long, value_delimiter = ',', value_name = "X,Y,Z")]
    pub dims: Option<Vec<u32>>,
    /// Their type, as NumPy calls it: uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32 or float64.
    #[arg(long = "type", requires = "dims", value_name = "TYPE")]
    pub kind: Option<SampleType>,
    /// Which of their bytes is first.
    #[arg(long, requires = "dims", value_parser = ["little", "big"], default_value = "little")]
    pub endian: String,
    /// World units from one to the next along x, y and z.
    #[arg(long, requires = "dims", value_delimiter = ',', value_name = "X,Y,Z")]
    pub spacing: Option<Vec<f64>>,
    /// Bytes before them; without, they are the end of the file.
    #[arg(long, requires = "dims", value_name = "BYTES")]
    pub skip: Option<u64>,
}

/// Reads the volume, and writes it.
pub(super) fn run(command: &Convert, quiet: bool) -> Result<(), Box<dyn Error>> {
    let path = &command.output;
    let known = VolumeFormat::from_path(path);
    let format = known.ok_or_else(|| format!("--output {}: end the name in {ENDS}", path.display()))?;
    output::check_folder(path)?;
    let shape = match &command.dims {
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
        None => shape::open(&command.input)?,
    };
    let Shape::Volume(volume) = shape else {
        let input = &command.input;
        return Err(format!("{input}: is no volume; `hypertexture field {input}` writes its distance field").into());
    };
    let mut bytes = Vec::new();
    format.write(&volume, &mut bytes)?;
    write_whole(path, &bytes).map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    if !quiet {
        let (low, high) = volume.range();
        let size = volume.size.map(|n| n.to_string()).join(" x ");
        say(&format!("volume     {size}, values {low} to {high}\nwrote {}\n", absolute(path)));
    }
    Ok(())
}

/// The numbers of three axes, if they are three.
fn three<T: Copy>(numbers: &[T]) -> Option<[T; 3]> {
    numbers.try_into().ok()
}

/// Ends of names of volumes that are written.
pub(super) const ENDS: &str = ".nrrd, .mha, .nii, .nii.gz or .npy";
