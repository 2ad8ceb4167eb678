//! Maps: values of pixels other than light, such as errors.

use super::{OutputError, PROGRAM, check};
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, SmallVec, Text, Vec2, WritableImage};
use hypertexture_support::write_whole;
use std::io::Cursor;
use std::path::Path;

/// Writes named channels of 32-bit floats, row by row from the top, to an OpenEXR file.
///
/// # Errors
/// Another format, or an error of the encoder or the system; the file is then unchanged.
pub fn write_map(path: &Path, size: [u32; 2], channels: &[(&str, Vec<f32>)]) -> Result<(), OutputError> {
    check(path)?;
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        channels.iter().map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.clone()))).collect();
    let [width, height] = size.map(|side| side as usize);
    let mut image = Image::from_channels(Vec2(width, height), AnyChannels::sort(channels));
    image.layer_data.attributes.software_name = Some(Text::from(PROGRAM));
    let mut bytes = Cursor::new(Vec::new());
    let shown = || path.display().to_string();
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| OutputError::Encode { path: shown(), reason: error.to_string() })?;
    write_whole(path, bytes.get_ref()).map_err(|source| OutputError::Write { path: shown(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.exr");
        let channel = |from: f32| (0..6).map(|at| from + at as f32).collect::<Vec<f32>>();
        write_map(
            &path,
            [3, 2],
            &[("R", channel(0.0)), ("G", channel(10.0)), ("B", channel(20.0)), ("estimate", channel(30.0))],
        )
        .unwrap();
        let read = exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
        let found: Vec<(String, Vec<f32>)> = read
            .layer_data
            .channel_data
            .list
            .iter()
            .map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect()))
            .collect();
        let expected = [("B", 20.0), ("G", 10.0), ("R", 0.0), ("estimate", 30.0)];
        assert_eq!(found, expected.map(|(name, from)| (name.to_string(), channel(from))));
        assert_eq!(image::open(&path).unwrap().to_rgb32f().get_pixel(2, 1).0, [5.0, 15.0, 25.0]);
    }
}
