//! References: what a picture would be if its light were summed exactly.
//!
//! Role: the truth that errors are measured against. Invariant: a reference belongs to a scene without its quality, and
//! says of each pixel how far it may be from the truth.

use crate::scene::{Quality, Scene};

/// A picture of known error.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Premultiplied linear RGBA, row by row from the top.
    pub pixels: Vec<[f64; 4]>,
    /// Error estimate of each pixel: the largest of its channels.
    pub estimate: Vec<f64>,
}

/// The scene with all taken away that decides how exactly it is drawn, and nothing that decides what it shows: scenes
/// with the same truth become equal. The size of a block of noise decides what the noise is.
pub fn truth_of(scene: &Scene) -> Scene {
    let Quality { supersampling, block_size, .. } = scene.quality;
    let quality = Quality { supersampling, block_size, ..Quality::default() };
    Scene { quality, ..scene.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Pass, TargetFormat, preset};

    #[test]
    fn scenes_that_differ_in_accuracy_alone_have_one_truth() {
        let fire = preset("fire").unwrap();
        let mut coarse = fire.clone();
        (coarse.quality.samples, coarse.quality.pass) = (8, Pass::March);
        coarse.quality.target = TargetFormat::Unorm8;
        assert_eq!(truth_of(&fire), truth_of(&coarse));
        coarse.effect.turbulence = "procedural".into();
        assert_ne!(truth_of(&fire), truth_of(&coarse));
    }
}
