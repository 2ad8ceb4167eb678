//! Shader stages.

/// Stage of an entry file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Fragment shader.
    Fragment,
    /// Compute shader.
    Compute,
}

impl Stage {
    /// Stage of an entry file by the end of its name: `.vert`, `.comp`, and any other for a fragment shader.
    pub fn of(entry: &str) -> Stage {
        match entry.rsplit('.').next() {
            Some("vert") => Stage::Vertex,
            Some("comp") => Stage::Compute,
            _ => Stage::Fragment,
        }
    }
}
