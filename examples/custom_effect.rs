//! An effect of one's own: a density modulation function in GLSL, whose parameter is set like every other. Writes
//! `rings.png` or the file that is named.

use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::{Subject, render};
use hypertexture::scene::{self, ParameterValue};
use hypertexture::{output, shader};
use std::error::Error;

const RINGS: &str = r"
// Rings around the y axis, cut into the soft region.
// @param ring_count = 9 in [1, 40]: Rings over the height of the object.
float rings(float density, Sample s) {
    return density * smoothstep(-0.2, 0.4, sin(3.14159265 * ring_count * s.x.y));
}
";

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).unwrap_or("rings.png".into());
    let library = shader::shipped().with_module("dmf", "rings", RINGS);
    let mut scene = scene::preset("fire")?;
    scene.object.input = "sphere".into();
    scene.effect.dmf = vec!["rings".into(), "fire".into()];
    scene.parameters.insert("ring_count".into(), ParameterValue::Number(7.0));
    scene.image.size = [320, 320];
    let subject = Subject::load(&scene, &library, &|_| ())?;
    let gpu = Gpu::new(&Options::default())?;
    let frame = render(&gpu, &library, &scene, &subject)?;
    let provenance = output::Provenance::of(&scene, &gpu.info().title(), &frame.measurements)?;
    output::write(&frame, scene.image.background, output::Depth::Eight, &provenance, file.as_ref())?;
    println!("{}\nwrote {file}", frame.measurements.modules);
    Ok(())
}
