//! Errors of exports.

/// Why a scene cannot be carried.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Its programs or inputs cannot be made.
    #[error(transparent)]
    Render(#[from] hypertexture::render::RenderError),
    /// WGSL cannot express the program.
    #[error("the program of the {program} cannot become WGSL: {reason}; use a module without it")]
    Wgsl {
        /// Name of the program.
        program: &'static str,
        /// Message of naga.
        reason: String,
    },
    /// An image exceeds the limits of browsers.
    #[error("{name}: {size:?} texels of {bytes} bytes in all; browsers take {limit}; use a smaller --resolution")]
    Large {
        /// Name of the image.
        name: String,
        /// Texels along each axis.
        size: [u32; 3],
        /// Bytes of the image.
        bytes: usize,
        /// The limit.
        limit: &'static str,
    },
}
