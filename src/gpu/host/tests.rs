//! Pictures recorded into a host's commands.

use super::*;
use crate::gpu::allocations::allocations;
use crate::gpu::faults::LOSING;
use crate::gpu::{Dimension, Image, ImageUse, Load, Options, Target};
use crate::render::{RenderError, Renderer, Subject, render};
use crate::scene::{Order, Pass, Scene, preset};
use crate::shader;
use hypertexture_support::faults::{lose, turn_on};
use hypertexture_support::validation_lock::ValidationLock;
use std::collections::VecDeque;

const SIZE: [u32; 2] = [48, 40];
const FORMAT: Format = Format::Rgba32Float;
const BEHIND: [f32; 4] = [0.1, 0.3, 0.2, 1.0];

/// A device as a host has it: that of the test, which is validated, and the same in the hands of a host.
fn host() -> [Gpu; 2] {
    let own = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
    let host = HostDevice {
        entry: own.0.instance.entry.clone(),
        instance: own.0.instance.raw.clone(),
        physical_device: own.0.physical,
        device: own.0.device.raw.clone(),
        features: vk::PhysicalDeviceFeatures::default(),
        queue: *own.queue(),
        queue_family: own.0.family,
    };
    // SAFETY: the handles are those of an open device, which is closed last.
    let gpu = unsafe { Gpu::from_raw(host, None) }.unwrap();
    [own, gpu]
}

/// A frame of a host that the device may still be drawing.
struct Flight<'a> {
    own: &'a Gpu,
    image: Image,
    depth: Option<Image>,
    buffer: vk::CommandBuffer,
    fence: vk::Fence,
    recording: Option<Recording>,
    /// Allocations by the recording.
    allocations: u64,
}

impl<'a> Flight<'a> {
    /// Records a picture over a color, with its depth or without.
    fn recorded(own: &'a Gpu, gpu: &Gpu, renderer: &mut Renderer, scene: &Scene, has_depth: bool) -> Flight<'a> {
        let size = Dimension::Plane(SIZE[0], SIZE[1]);
        let image = Image::new(own, "host", size, FORMAT, ImageUse::Target(1)).unwrap();
        let depth = Image::new(own, "depth", size, Format::R32Float, ImageUse::Target(1)).unwrap();
        let depth = has_depth.then_some(depth);
        let device = &own.0.device;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(own.0.pool.handle).command_buffer_count(1);
        // SAFETY: the test is the only user of the device, and waits for what it submits.
        unsafe {
            let buffer = device.allocate_command_buffers(&info).unwrap()[0];
            device.begin_command_buffer(buffer, &vk::CommandBufferBeginInfo::default()).unwrap();
            let mut commands = Commands { gpu: own, buffer };
            for image in [Some(&image), depth.as_ref()].into_iter().flatten() {
                commands.render(Target::of(image), Load::Clear(BEHIND), |_| ());
                commands.transition(image, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
            }
            let target = |image: &Image| HostTarget { view: image.view, format: image.format().vk(), size: SIZE };
            let mut host = gpu.host_commands(buffer, target(&image)).unwrap();
            if let Some(depth) = &depth {
                host = host.with_depth(target(depth)).unwrap();
            }
            let (recording, allocations) = allocations(|| renderer.record(&mut host, scene).unwrap());
            device.end_command_buffer(buffer).unwrap();
            let fence = device.create_fence(&vk::FenceCreateInfo::default(), None).unwrap();
            Flight { own, image, depth, buffer, fence, recording: Some(recording), allocations }
        }
    }

    fn submit(&self) {
        let buffers = [self.buffer];
        let submits = [vk::SubmitInfo::default().command_buffers(&buffers)];
        // SAFETY: the commands are complete, and what they use is there until the fence is signaled.
        unsafe { self.own.0.device.queue_submit(*self.own.queue(), &submits, self.fence) }.unwrap();
    }

    /// Picture and depth after the submission.
    fn seen(self) -> (Vec<[f32; 4]>, Option<Vec<f32>>) {
        // SAFETY: the fence belongs to the device.
        unsafe { self.own.0.device.wait_for_fences(&[self.fence], true, u64::MAX) }.unwrap();
        let depth = |image: &Image| image.read().unwrap().into_iter().map(|[depth, ..]| depth).collect();
        (self.image.read().unwrap(), self.depth.as_ref().map(depth))
    }
}

impl Drop for Flight<'_> {
    fn drop(&mut self) {
        self.recording = None;
        // SAFETY: the commands were executed, or are not.
        unsafe {
            self.own.0.device.destroy_fence(self.fence, None);
            self.own.0.device.free_command_buffers(self.own.0.pool.handle, &[self.buffer]);
        }
    }
}

/// The most by which a picture that a host sees differs from one that was rendered, over what the host has drawn.
fn worst(rendered: &[[f32; 4]], seen: &[[f32; 4]]) -> f32 {
    let over = |pixel: &[f32; 4], c: usize| pixel[c] + (1.0 - pixel[3]) * BEHIND[c];
    let off = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| (over(a, c) - b[c]).abs()).fold(0.0, f32::max);
    rendered.iter().zip(seen).map(off).fold(0.0, f32::max)
}

/// Picture and depth in the images of a host.
fn recorded(
    own: &Gpu,
    gpu: &Gpu,
    renderer: &mut Renderer,
    scene: &Scene,
    has_depth: bool,
) -> (Vec<[f32; 4]>, Option<Vec<f32>>) {
    let flight = Flight::recorded(own, gpu, renderer, scene, has_depth);
    flight.submit();
    flight.seen()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_recorded_picture_is_render_over_the_host_picture() {
    let _lock = ValidationLock::acquire();
    let [own, gpu] = host();
    let messages = own.messages();
    let library = shader::shipped();
    for name in ["fire_ball", "fur"] {
        let mut scene = preset(name).unwrap();
        scene.object.input = "sphere".into();
        (scene.image.size, scene.quality.samples, scene.quality.order) = (SIZE, 48, Order::BackToFront);
        scene.light.shadow_resolution = 16;
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let mut renderer = Renderer::new(&gpu, &library, &subject);
        for pass in [Pass::Slices, Pass::March] {
            scene.quality.pass = pass;
            let frame = render(&own, &library, &scene, &subject).unwrap();
            let deep = Renderer::new(&own, &library, &subject).render_depth(&scene).unwrap();
            // Twice: the second picture is made of what the first has left.
            for (found, depth) in [false, true].map(|depth| recorded(&own, &gpu, &mut renderer, &scene, depth)) {
                assert!(depth.is_none_or(|depth| depth == deep), "{name}, {pass:?}: another depth");
                let worst = worst(&frame.pixels, &found);
                assert!(worst < 1e-5, "{name}, {pass:?}: {worst}");
                assert!(frame.pixels.iter().any(|pixel| pixel[3] > 0.5), "{name}: nothing is drawn");
            }
        }
        scene.quality.msaa = 4;
        // SAFETY: nothing is recorded.
        let commands = |size, format| unsafe {
            gpu.host_commands(vk::CommandBuffer::null(), HostTarget { view: vk::ImageView::null(), format, size })
        };
        let refused = renderer.record(&mut commands(SIZE, FORMAT.vk()).unwrap(), &scene).map(drop);
        assert!(refused.unwrap_err().to_string().ends_with("use quality.msaa = 1"));
        for size in [[0, 8], [8, gpu.info().max_image + 1]] {
            let Err(GpuError::TooLarge { asked, .. }) = commands(size, FORMAT.vk()) else { panic!("{size:?}") };
            assert_eq!(asked, format!("{} x {} x 1 texels", size[0], size[1]));
        }
        let Err(GpuError::Unsupported { what, .. }) = commands(SIZE, vk::Format::R8_SINT) else { panic!() };
        assert_eq!(what, "blending into R8_SINT");
        for (size, format, said) in [
            (SIZE, vk::Format::D32_SFLOAT, "depth in D32_SFLOAT: use an image of R32_SFLOAT"),
            ([48, 41], Format::R32Float.vk(), "depth of 48 x 41 pixels: use an image of 48 x 40 as the picture's"),
        ] {
            // SAFETY: nothing is recorded.
            let depth = unsafe {
                let view = vk::ImageView::null();
                commands(SIZE, FORMAT.vk()).unwrap().with_depth(HostTarget { view, format, size })
            };
            let refused = depth.map(drop).unwrap_err();
            assert!(
                matches!(refused, GpuError::Unsupported { .. }) && refused.to_string().ends_with(said),
                "{refused}"
            );
        }
    }
    drop(gpu);
    drop(own);
    assert_eq!(messages.take(), Vec::<String>::new());
}

/// Most allocations by the recording of an unchanged scene, and of one from another view.
const ALLOCATIONS: [u64; 2] = [100, 1000];

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn recording_allocates_little() {
    let _lock = ValidationLock::acquire();
    let [own, gpu] = host();
    let library = shader::shipped();
    for (name, input) in [("fire", "sphere"), ("fur", "teapot")] {
        let mut scene = preset(name).unwrap();
        scene.object.input = input.into();
        (scene.image.size, scene.quality.samples, scene.object.resolution) = (SIZE, 32, 32);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let mut renderer = Renderer::new(&gpu, &library, &subject);
        let (mut still, mut moving) = (Vec::new(), Vec::new());
        for (counted, step) in [(&mut still, 0.0), (&mut moving, 1.0)] {
            for _ in 0..6 {
                scene.camera.azimuth += step;
                let (is_ready, asked) = allocations(|| renderer.is_recordable(&scene, FORMAT).unwrap());
                let flight = Flight::recorded(&own, &gpu, &mut renderer, &scene, false);
                flight.submit();
                counted.extend(is_ready.then_some(asked + flight.allocations));
                flight.seen();
            }
        }
        println!("allocations of recordings of {name}: {still:?} of an unchanged scene, {moving:?} of a moving one");
        for (counted, most) in [(still, ALLOCATIONS[0]), (moving, ALLOCATIONS[1])] {
            assert!(counted.len() > 2 && counted[2..].iter().all(|count| *count <= most), "{name}: {counted:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn moving_frames_of_a_host_are_recorded_without_a_wait() {
    let _lock = ValidationLock::acquire();
    let [own, gpu] = host();
    let messages = own.messages();
    let library = shader::shipped();
    for name in ["fire_ball", "fire"] {
        let mut scene = preset(name).unwrap();
        scene.object.input = "sphere".into();
        (scene.image.size, scene.quality.samples, scene.quality.pass) = (SIZE, 48, Pass::March);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let mut renderer = Renderer::new(&gpu, &library, &subject);
        renderer.set_full_size([640, 480]); // cells pay
        while !renderer.is_recordable_with_depth(&scene, FORMAT).unwrap() {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        // A frame that the host throws away: what it was to copy the next one copies.
        if let Some(recording) = Flight::recorded(&own, &gpu, &mut renderer, &scene, true).recording.take() {
            recording.discard();
        }
        let mut truth = Renderer::new(&own, &library, &subject);
        let mut in_flight: VecDeque<(f64, Flight<'_>)> = VecDeque::new();
        let mut check = |(time, flight): (f64, Flight<'_>)| {
            let mut then = scene.clone();
            then.camera.time = time;
            let (seen, depth) = flight.seen();
            let worst = worst(&truth.render(&then).unwrap().pixels, &seen);
            assert!(worst < 1e-5, "{name} at {time} s: {worst}");
            let is_that = |depth| depth == truth.render_depth(&then).unwrap();
            assert!(depth.is_none_or(is_that), "{name} at {time} s: another depth");
        };
        let mut moving = scene.clone();
        for frame in 0..60 {
            moving.camera.time = f64::from(frame) / 30.0;
            let flight = Flight::recorded(&own, &gpu, &mut renderer, &moving, frame % 4 == 0);
            in_flight.push_back((moving.camera.time, flight));
            in_flight.iter().last().into_iter().for_each(|(_, flight)| flight.submit());
            // The second half has cells, however slow the machine is.
            while frame == 30 && renderer.recorded_cells() == (false, 0.0) {
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
            if in_flight.len() == 2 {
                in_flight.pop_front().into_iter().for_each(&mut check);
            }
        }
        in_flight.into_iter().for_each(check);
        assert_eq!(gpu.waits(), 0, "{name}");
        let (_, empty) = renderer.recorded_cells();
        assert!(empty > 0.1, "{name}: {empty}");
    }
    drop(gpu);
    drop(own);
    assert_eq!(messages.take(), Vec::<String>::new());
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_lost_device_fails_its_calls_and_no_other_device() {
    let _lock = ValidationLock::acquire();
    turn_on();
    let library = shader::shipped();
    let mut scene = preset("fur").unwrap();
    scene.object.input = "sphere".into();
    (scene.image.size, scene.quality.samples, scene.light.shadow_resolution) = (SIZE, 32, 16);
    let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
    let mut other_light = scene.clone();
    other_light.light.position[0] += 1.0;
    let mut pictures = Vec::new();
    for call in LOSING {
        let [own, gpu] = host();
        let messages = own.messages();
        let mut renderer = Renderer::new(&gpu, &library, &subject);
        pictures.push(renderer.render(&scene).unwrap().pixels);
        lose(Some(call));
        let target = HostTarget { view: vk::ImageView::null(), format: FORMAT.vk(), size: SIZE };
        // SAFETY: nothing is recorded, since the shadows are not cast.
        let mut commands = unsafe { gpu.host_commands(vk::CommandBuffer::null(), target) }.unwrap();
        let done = [
            renderer.render(&scene).map(drop),
            renderer.render_depth(&scene).map(drop),
            renderer.record(&mut commands, &other_light).map(drop),
            Renderer::new(&gpu, &library, &subject).render(&scene).map(drop),
        ];
        for (number, done) in done.into_iter().enumerate() {
            let is_lost = matches!(&done, Err(RenderError::Gpu(error)) if error.is_lost());
            assert!(is_lost, "{call}, {number}: {done:?}");
        }
        drop(renderer);
        drop(gpu);
        lose(None);
        drop(own);
        assert_eq!(messages.take(), Vec::<String>::new(), "{call}");
    }
    assert!(pictures.iter().all(|picture| *picture == pictures[0]), "another device draws another picture");
}
