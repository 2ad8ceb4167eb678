//! Parameters, statistics and progress of field computations.

/// Parameters of a distance field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Samples along the longest side of the grid with its margin, 8 to 1024.
    pub resolution: u32,
    /// World distance that the grid extends beyond the bounds of the shape, at least 0.
    pub margin: f32,
    /// World distance, at least 0, up to which the field is exact. Beyond it is a lower bound, short by at most a quarter of a
    /// voxel.
    pub band: f32,
    /// Iso-value of a scalar volume's surface.
    pub iso: f32,
    /// Thickness of a shell around the surface, half of it to each side (world units, at least 0). 0 gives a solid.
    pub shell: f32,
}

/// Statistics of a computed field, for the user.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FieldReport {
    /// Triangles of the mesh or of the volume's iso-surface; 0 for a formula.
    pub triangles: usize,
    /// Edges with a single triangle, after corners at equal positions are merged. 0 for a closed mesh.
    pub open_edges: usize,
    /// Triangles flipped to agree with their neighbors.
    pub turned_triangles: usize,
    /// Whether solids overlap, so that surfaces inside them were dropped.
    pub buried: bool,
    /// Whether the work on overlaps was cut off. Some inner surfaces are left, so distances inside are too short there.
    pub tangled: bool,
    /// Triangles added to close holes.
    pub closing_triangles: usize,
    /// Samples with exact distances.
    pub exact: u64,
    /// Whether the field was read from the cache. The counts are those of its computation.
    pub from_cache: bool,
    /// Wall-clock milliseconds.
    pub ms: f64,
}

/// Callback for the progress of a computation, called with a fraction in [0, 1] from any thread.
pub type Progress<'a> = &'a (dyn Fn(f32) + Sync);
