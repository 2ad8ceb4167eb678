//! Texturing and hypertexturing of volumetric objects: fur, fire, melting and more around a mesh, a scan or a formula.
//!
//! # Theory
//! A *soft object* is a density D in \[0, 1\] over space: 1 in the hard region, 0 outside, between in the soft region
//! (Perlin and Hoffert 1989). A *density modulation function* (DMF) changes that density before it is drawn. Miller and
//! Jones 2005 take D from a signed distance field in a 3D texture, draw view-aligned slices through it (proxy geometry), and let
//! each fragment decide what it is: rejected, surface, or soft matter with an opacity of `1 - (1 - D)^(c step)`, which
//! does not depend on how a path is cut into steps.
//!
//! # Practice
//! ```no_run
//! use hypertexture::{shader, gpu, render, scene};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let library = shader::shipped();
//! let mut scene = scene::preset("fur")?;
//! scene.object.input = "torus".into();
//! let subject = render::Subject::load(&scene, &library, &|_| ())?;
//! let gpu = gpu::Gpu::new(&gpu::Options::default())?;
//! let frame = render::render(&gpu, &library, &scene, &subject)?;
//! println!("{} slices in {:.1} ms", frame.measurements.slices, frame.measurements.gpu_ms);
//! # Ok(())
//! # }
//! ```
//! An effect of your own is one GLSL file in a slot: [`shader::Library::with_module`].
//!
//! # Map
//! ```text
//! mesh | scalar volume | formula                      shape
//!    -> signed distance field (world units)           field
//! preset, file, command line -> scene                 scene
//!    -> the GLSL modules it needs, linked             glsl, variant
//! field, transfer map, noise -> texels                texture, noise
//! proxy slices, or rays through the same samples      pass
//!    -> device                                        gpu
//! all of it, top to bottom -> picture, measurements   render
//!    -> PNG, EXR; a page                              output, gallery
//! the same program in f64 and in intervals            exact
//! its cost beforehand; many pictures; many processes  predict, sequence, shard
//! pictures in a process that may end by one           worker
//! its error against its cost; the fastest settings     reference, compare, pick
//! analytic references; a picture and its own scene      verify
//! all of it, live in a window                         view
//! ```

#[cfg(feature = "cli")]
pub mod cli;
pub mod exact;
pub mod field;
pub mod gpu;
#[cfg(feature = "measure")]
pub mod measure;
pub mod noise;
pub mod output;
pub mod render;
pub mod scene;
pub mod shader;
pub mod shape;
mod support;
#[cfg(feature = "viewer")]
pub mod viewer;
