//! A scene in the frames of a wgpu program: on wgpu's own Vulkan device, between its passes, with two frames in flight.
//!
//! wgpu draws pillars; the scene is recorded into textures of color and depth; wgpu composes both by depth.
//! `cargo run --release -- wgpu.png 60` draws 60 frames around the object and writes the last.

mod device;
mod frame;

use device::Host;
use frame::{Frame, Passes};
use hypertexture::glam::camera::rh;
use hypertexture::glam::{Mat4, Vec3};
use hypertexture::render::{Renderer, Subject};
use hypertexture::{scene, shader};
use std::collections::VecDeque;
use std::error::Error;
use std::f32::consts::TAU;
use std::time::Instant;

const SIZE: [u32; 2] = [640, 400];
/// Frames that the device may work on while the next one is recorded.
const IN_FLIGHT: usize = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or("wgpu.png".into());
    let frames: u32 = arguments.next().map_or(Ok(60), |number| number.parse())?;

    let host = Host::new()?;
    let library = shader::shipped();
    let mut scene = scene::preset("fire")?;
    scene.object.input = "torus".into();
    let subject = Subject::load(&scene, &library, &|_| ())?;
    let mut renderer = Renderer::new(&host.gpu, &library, &subject);
    let passes = Passes::new(&host.device);
    let textures: Vec<Frame> = (0..IN_FLIGHT).map(|_| Frame::new(&host.device, &passes)).collect();

    let mut flying = VecDeque::new();
    let (mut drawn, start) = (0, Instant::now());
    while drawn < frames {
        // The camera of the host; the view maps object space.
        let turn = 0.6 + TAU * drawn as f32 / frames as f32;
        let eye = 4.2 * Vec3::new(turn.sin(), 0.45, turn.cos());
        let view = rh::view::look_at_mat4(eye, Vec3::ZERO, Vec3::Y);
        let projection = rh::proj::directx::perspective(0.8, SIZE[0] as f32 / SIZE[1] as f32, 0.1, 50.0);
        let object_view = view * subject.world();
        scene.camera.look_through(object_view, projection)?;
        scene.camera.time = f64::from(drawn) / 60.0;
        if !renderer.is_recordable_with_depth(&scene, host.gpu.host_format(frame::COLOR_VK)?)? {
            std::thread::sleep(std::time::Duration::from_millis(5)); // a host draws something else meanwhile
            continue;
        }
        if flying.len() == IN_FLIGHT {
            host.finish(flying.pop_front())?;
        }
        let frame = &textures[drawn as usize % IN_FLIGHT];
        let before = passes.before(&host, frame, projection * view);
        let (native, recording) = host.record(frame, &mut renderer, &scene)?;
        let after = passes.after(&host, frame, projection, object_view);
        flying.push_back((host.queue.submit([before, native, after]), recording));
        drawn += 1;
    }
    while !flying.is_empty() {
        host.finish(flying.pop_front())?;
    }
    let rate = f64::from(frames) / start.elapsed().as_secs_f64();
    let last = &textures[(frames as usize - 1) % IN_FLIGHT];
    let mut encoder = png::Encoder::new(std::fs::File::create(&file)?, SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(&last.read(&host)?)?;
    println!("{frames} frames, {rate:.1} a second; wrote {file}");
    Ok(())
}

/// Column-major floats of a matrix, for a uniform block.
fn floats(matrix: Mat4) -> [f32; 16] {
    matrix.to_cols_array()
}
