//! Names of bindings in `interface.glsl` and `part.glsl`.

pub(crate) const VOLUME: &str = "volume_image";
pub(crate) const BRICKS: &str = "brick_image";
pub(crate) const CLOSEST: &str = "closest_image";
pub(crate) const CLASSIFIED: &str = "classified_image";
pub(crate) const TRANSFER: &str = "transfer_image";
pub(crate) const INDEX: &str = "index_image";
pub(crate) const SEGMENT: &str = "segment_image";
pub(crate) const SHADOW: &str = "shadow_image";
pub(crate) const LIGHT_BEFORE: &str = "light_before_image";
pub(crate) const LIGHT_BEHIND: &str = "light_behind_image";
pub(crate) const CELLS: &str = "cell_image";
/// The target of the picture in the program of the opaque mask.
pub(crate) const TARGET: &str = "target_image";
pub(crate) const GROOM_SHAPE: &str = "groom_shape_image";
pub(crate) const GROOM_LOOK: &str = "groom_look_image";
pub(crate) const BLOCK_SAMPLER: &str = "block_sampler";

/// Images that are rendered with the picture.
pub(crate) const RENDERED: [&str; 4] = [SHADOW, LIGHT_BEFORE, LIGHT_BEHIND, CELLS];
