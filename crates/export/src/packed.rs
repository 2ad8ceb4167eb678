//! Texels for `page/texels.js`: differences from the neighbors, split into bytes, gzip.
//!
//! Ways to closest points that no ray reads repeat the one before. The differences of a channel are taken along each axis in turn, which leaves little but rounding where it is smooth. They
//! are folded to codes from 0 on; all lowest bytes of a channel come first, then the next ones.

use flate2::Compression;
use flate2::write::GzEncoder;
use hypertexture::gpu::Format;
use hypertexture::render::variant::{ImageInput, ObjectImage};
use hypertexture::render::{Portable, PortableImage};
use rayon::prelude::*;
use std::io::Write;

/// Compression of differences, which are mostly noise. Higher: twice as slow for a percent.
const LEVEL: u32 = 5;

/// Lowest bits of each channel that pages leave out. Normals keep 12 bits, ways to closest points 13, which is a 4000th of the
/// object; distances, noise and colors keep all. Fewer: a furry teapot takes 3 MB more.
pub(crate) fn left_out(image: &PortableImage) -> [u32; 4] {
    match (image.input, image.format) {
        (ImageInput::Object(ObjectImage::Volume), Format::Rgba16Unorm) => [4, 4, 4, 0],
        (ImageInput::Object(ObjectImage::Closest), Format::Rgba16Unorm) => [3; 4],
        _ => [0; 4],
    }
}

/// The compressed texels of an image.
pub(crate) fn pack(portable: &Portable, image: &PortableImage) -> Vec<u8> {
    let channels = image.format.channels() as usize;
    let bytes = image.format.bytes() as usize / channels;
    let (left_out, unread) = (left_out(image), portable.unread(image));
    let mut first = 0;
    let mut planes = Vec::new();
    for level in 0..image.levels {
        let [x, y, z] = image.dimension.size().map(|side| (side >> level).max(1) as usize);
        let end = (first + x * y * z * bytes * channels).min(image.bytes.len());
        let texels = &image.bytes[first..end];
        let of_channel =
            |channel| differences(texels, [x, y, z], bytes, (channel, channels), left_out[channel], unread.as_deref());
        planes.extend((0..channels).into_par_iter().map(of_channel).collect::<Vec<_>>());
        first = end;
    }
    let mut encoder = GzEncoder::new(Vec::new(), Compression::new(LEVEL));
    let written = planes.iter().try_for_each(|plane| encoder.write_all(plane)).and_then(|()| encoder.finish());
    written.expect("a vector takes all bytes")
}

/// Codes of the differences of a channel without its lowest bits, byte by byte.
fn differences(
    texels: &[u8],
    [x, y, z]: [usize; 3],
    bytes: usize,
    (channel, channels): (usize, usize),
    left_out: u32,
    unread: Option<&[bool]>,
) -> Vec<u8> {
    let (count, shift) = (x * y * z, 32 - 8 * bytes as u32);
    let code = |texel: &[u8]| {
        let own = &texel[channel * bytes..][..bytes];
        own.iter().rev().fold(0u32, |value, byte| value << 8 | u32::from(*byte))
    };
    let (half, most) = ((1 << left_out) >> 1, (u32::MAX >> shift) >> left_out);
    let rounded = |texel: &[u8]| if left_out == 0 { code(texel) } else { ((code(texel) + half) >> left_out).min(most) };
    let mut values: Vec<u32> = texels.chunks_exact(bytes * channels).map(rounded).collect();
    for at in unread.into_iter().flat_map(|unread| (1..unread.len()).filter(|at| unread[*at] && at % x > 0)) {
        values[at] = values[at - 1];
    }
    for (step, across) in [(1, x), (x, y), (x * y, z)].into_iter().filter(|(_, across)| *across > 1) {
        for row in values.chunks_exact_mut(step * across) {
            (step..row.len()).rev().for_each(|at| row[at] = row[at].wrapping_sub(row[at - step]));
        }
    }
    let mut planes = vec![0; bytes * count];
    for (at, value) in values.into_iter().enumerate() {
        let difference = ((value << shift) as i32) >> shift;
        let folded = (difference << 1 ^ difference >> 31) as u32;
        (0..bytes).for_each(|byte| planes[byte * count + at] = (folded >> (8 * byte)) as u8);
    }
    planes
}
