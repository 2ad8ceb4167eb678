//! Errors of field computations.

/// Why a field cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// No sample lies on one of the sides of the iso-value.
    #[error("no surface at iso-value {iso}: {}", match min < max {
        true => format!("the values range from {min} to {max}; choose one above {min}, up to {max}"),
        false => format!("all values are {min}, and no other iso-value has one; is it the right file?"),
    })]
    NoSurface {
        /// The requested iso-value.
        iso: f32,
        /// Smallest value.
        min: f32,
        /// Largest value.
        max: f32,
    },
    /// The resolution is out of range.
    #[error("resolution {resolution} is not in 8 to 1024; 64 to 256 suit most shapes")]
    Resolution {
        /// Samples along the longest side.
        resolution: u32,
    },
    /// A length is negative or not finite.
    #[error("{name} {value} is not a length; give a finite number of at least 0 (world units)")]
    Length {
        /// Name of the length.
        name: &'static str,
        /// Requested value.
        value: f32,
    },
    /// f32 cannot distinguish neighboring samples: the shape is too small, too large or too far from the origin.
    #[error(
        "samples over a side of {side:e} at coordinates up to {magnitude:e} cannot be told apart in 32 bits; \
         move the shape to the origin, scale it, or widen the margin"
    )]
    Extent {
        /// Longest side of the grid, world units.
        side: f64,
        /// Largest coordinate of the grid.
        magnitude: f32,
    },
    /// The mesh has no triangle.
    #[error("the mesh has 0 triangles with an area, at least 1 is needed; check the file's faces")]
    EmptyMesh,
    /// A triangle has a vertex index out of range.
    #[error("a triangle has corner {index} but there are {vertices} vertices; check the file's faces")]
    Corner {
        /// The index.
        index: u32,
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// A volume's number of values does not match its size.
    #[error("a volume of {size:?} samples needs {expected} values, at least 1, got {found}; check the file's header")]
    Samples {
        /// Samples per axis.
        size: [u32; 3],
        /// Their product.
        expected: u64,
        /// Number of values.
        found: u64,
    },
    /// A scalar volume was given for one of signed distances.
    #[error("the volume holds scalars, signed distances are needed; compute them with an iso-value")]
    Content,
    /// Signed distances on a grid that is not axis-aligned.
    #[error("the axes of the signed distances are not those of the world; resample them onto these")]
    Oblique,
    /// The computation exceeds the memory limit.
    #[error("a grid of {size:?} needs {bytes} bytes, the limit is {limit}; lower the resolution")]
    Memory {
        /// Estimated need.
        bytes: u64,
        /// The limit.
        limit: u64,
        /// Samples per axis.
        size: [u32; 3],
    },
}
