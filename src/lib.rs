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
//! println!("{} samples in depth, {:.1} ms", frame.measurements.slices, frame.measurements.gpu_ms);
//! # Ok(())
//! # }
//! ```
//! A custom effect is one GLSL file in a slot: [`shader::Library::with_module`].
//!
//! # Terms
//! - *Object*: what is textured: a mesh, a scalar volume or a formula; with its field it is a [`render::Subject`].
//! - *Hard region*, *soft region*: where the signed distance is below the inner iso-value; from there to the outer one.
//! - *Effect*: the modules that fill the *slots* of a program, such as `dmf`, `surface`, `medium`; each declares its
//!   *parameters* (`// @param`).
//! - *Scene*: object, effect, parameters, light, camera, image and quality: a [`scene::Scene`], as TOML or as a value.
//! - *Variant*: the program of a scene, linked from the modules that it needs: [`render::variant::Variant`].
//! - *Slices*, *rays*: the two passes through the same samples, at equal distances from the camera.
//!
//! # Units and axes
//! Object space is centered on the object, whose longest side spans -1 to 1; x points right, y up, z to the viewer, and
//! lengths are *object units*. In eye space the camera is at the origin and looks along -z; a light is placed there, around
//! the center of the object. Colors of a scene are sRGB codes, those of a [`render::Frame`] linear and premultiplied.
//! Angles are degrees, times are seconds.
//!
//! # Devices and threads
//! Vulkan 1.3 with [`gpu::required_features`], all of them mandatory in 1.3, and no extension. [`gpu::Gpu`] is shared by its
//! clones and by threads, whose submissions take turns; a [`render::Renderer`] belongs to one thread at a time. Another
//! program's device serves as well: [`gpu::Gpu::from_raw`], and [`render::Renderer::record`] draws into its image.
//! Everything but `gpu` and `render` works without a Vulkan loader.
//!
//! # Examples
//! In the folder `examples`: `headless` (a picture in a few lines), `embed` (a scene in a host's own image), `custom_effect`.
//!
//! # Features
//! `glsl` (on by default): a GLSL compiler, for modules of one's own. Without it: fields, scenes, files, and pictures by the
//! programs that ship, which are those of the six effects by rays. `window`: devices that draw into windows.

pub mod gpu;
pub mod output;
pub mod render;
pub mod scene;
pub mod shader;

pub use {
    hypertexture_eval as eval, hypertexture_field as field, hypertexture_noise as noise, hypertexture_shape as shape,
};

/// Vectors and matrices, as this crate takes and gives them.
pub use glam;
