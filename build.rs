//! Compiles the shipped GLSL programs.
fn main() {}
