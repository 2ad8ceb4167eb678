//! Values of a volume as bytes, for all writers.

use crate::shape::Volume;
use flate2::Compression;
use std::io::{self, Write};

/// Bytes encoded at a time.
const BLOCK_BYTES: usize = 64 * 1024;
/// Level of deflate. On a distance field and a CT scan level 1 took a quarter less time for 7 to 50 percent larger files,
/// level 6 up to twice as long for up to 5 percent smaller ones.
pub(crate) const LEVEL: Compression = Compression::new(3);

/// Checks the number of values against the size.
pub(crate) fn check(volume: &Volume) -> io::Result<()> {
    let [x, y, z] = volume.size;
    let voxels = volume.size.iter().try_fold(1_usize, |product, &n| product.checked_mul(n as usize));
    if voxels == Some(volume.values.len()) {
        return Ok(());
    }
    let found = volume.values.len();
    let message = format!("a volume of {x} x {y} x {z} needs their product of values, it has {found}");
    Err(io::Error::new(io::ErrorKind::InvalidInput, message))
}

/// Writes the values in little endian.
pub(super) fn write_values(volume: &Volume, to: &mut dyn Write) -> io::Result<()> {
    let mut block = Vec::with_capacity(BLOCK_BYTES);
    for values in volume.values.chunks(BLOCK_BYTES / 4) {
        block.clear();
        block.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        to.write_all(&block)?;
    }
    Ok(())
}
