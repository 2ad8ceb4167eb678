//! Shader stages.

/// Stage of an entry file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Fragment shader.
    Fragment,
    /// Compute shader, compiled with the macro `COMPUTE`: its own file, or that of a fragment shader.
    Compute,
}

impl Stage {
    /// Stage of an entry file by the end of its name: `.vert`, `.comp` or `.frag#compute`, and any other for a fragment
    /// shader.
    pub fn of(entry: &str) -> Stage {
        match entry.rsplit('.').next() {
            Some("vert") => Stage::Vertex,
            Some("comp" | "frag#compute") => Stage::Compute,
            _ => Stage::Fragment,
        }
    }
}
