//! Disk cache of references, which take seconds to compute.

use super::Reference;
use hypertexture::output::identity_of_texts;
use hypertexture::render::variant::Variant;
use hypertexture::render::{RenderError, Subject};
use hypertexture::shader::Library;
use hypertexture_support::disk_cache::{self, CacheKind};

/// Version of the references; raise it with any change of their values.
const VERSION: u32 = 8;
/// Limit of the cache. Lower: the references of one report evict each other. Higher: the disk fills up.
const KIND: CacheKind = CacheKind { ends: &["reference"], limit: 256 << 20 };

/// Cache key of a [`super::truth_of`] scene: the hash of all inputs of its reference.
pub(super) fn key(
    truth: &Variant,
    library: &Library,
    subject: &Subject,
    tolerance: f64,
) -> Result<blake3::Hash, RenderError> {
    let mut hash = blake3::Hasher::new();
    hash.update(&VERSION.to_le_bytes()).update(&tolerance.to_le_bytes());
    hash.update(identity_of_texts(truth, library, subject)?.as_bytes());
    Ok(hash.finalize())
}

/// Loads a reference.
pub(super) fn load(key: blake3::Hash, size: [u32; 2]) -> Option<Reference> {
    parse(&disk_cache::load(KIND, key)?, size)
}

/// Saves a reference.
pub(super) fn save(key: blake3::Hash, reference: &Reference) {
    disk_cache::save(KIND, key, &bytes(reference));
}

fn bytes(reference: &Reference) -> Vec<u8> {
    let rows = reference.pixels.iter().zip(&reference.estimate).zip(&reference.open);
    let values = rows.flat_map(|((pixel, estimate), open)| pixel.iter().chain([estimate, open]));
    values.flat_map(|value| value.to_le_bytes()).collect()
}

fn parse(bytes: &[u8], size: [u32; 2]) -> Option<Reference> {
    let count = size[0] as usize * size[1] as usize;
    let numbers = bytes.as_chunks::<8>();
    if numbers.0.len() != 6 * count || !numbers.1.is_empty() {
        return None;
    }
    let rows = numbers.0.as_chunks::<6>().0.iter().map(|row| row.map(f64::from_le_bytes));
    let (pixels, (estimate, open)) = rows.map(|[r, g, b, a, estimate, open]| ([r, g, b, a], (estimate, open))).unzip();
    Some(Reference { size, pixels, estimate, open })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_comes_back_as_it_was() {
        let pixels = vec![[0.1, 0.2, 0.3, 0.4], [1.0, 0.0, 1e-9, 0.5]];
        let reference = Reference { size: [2, 1], pixels, estimate: vec![1e-7, 2e-6], open: vec![0.0, 1.0] };
        let written = bytes(&reference);
        assert_eq!(parse(&written, [1, 1]), None);
        assert_eq!(parse(&written[..written.len() - 1], [2, 1]), None);
        assert_eq!(parse(&written, [2, 1]), Some(reference));
    }
}
