//! Shader stages.

/// Stage of an entry file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Fragment shader.
    Fragment,
    /// Compute shader: a fragment shader's file that is compiled with the macro `COMPUTE`.
    Compute,
}

impl Stage {
    /// Stage of an entry file by the end of its name: `.vert`, `.frag#compute`, and any other for a fragment shader.
    pub fn of(entry: &str) -> Stage {
        match entry.rsplit('.').next() {
            Some("vert") => Stage::Vertex,
            Some("frag#compute") => Stage::Compute,
            _ => Stage::Fragment,
        }
    }
}
