//! A picture in a few lines: fur on a torus, written to `fur.png` or the file that is named.

use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::{Subject, render};
use hypertexture::{output, scene, shader};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).unwrap_or("fur.png".into());
    let library = shader::shipped();
    let mut scene = scene::preset("fur")?;
    scene.object.input = "torus".into();
    scene.image.size = [320, 320];
    let subject = Subject::load(&scene, &library, &|_| ())?;
    let gpu = Gpu::new(&Options::default())?;
    let frame = render(&gpu, &library, &scene, &subject)?;
    let provenance = output::Provenance::of(&scene, &gpu.info().title(), &frame.measurements)?;
    output::write(&frame, scene.image.background, output::Depth::Eight, &provenance, file.as_ref())?;
    println!("{} slices in {:.1} ms, wrote {file}", frame.measurements.slices, frame.measurements.gpu_ms);
    Ok(())
}
