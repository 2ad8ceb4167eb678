//! Limits of the memory that a small picture allocates on the processor.

use super::renderer::Renderer;
use crate::gpu::allocations::allocations;
use crate::gpu::{Gpu, Options};
use crate::render::subject::Subject;
use crate::scene::preset;
use crate::shader;
use hypertexture_support::validation_lock::ValidationLock;

/// Most allocations of a picture whose view or time differs from that of the one before.
const OF_A_FRAME: u64 = 1000;

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_small_frame_allocates_little() {
    let _lock = ValidationLock::acquire();
    let gpu = Gpu::new(&Options::from_env()).unwrap();
    let library = shader::shipped();
    for name in ["fire", "fur"] {
        let mut scene = preset(name).unwrap();
        (scene.image.size, scene.quality.samples, scene.object.resolution) = ([16, 16], 32, 32);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let mut renderer = Renderer::new(&gpu, &library, &subject);
        let mut counted = Vec::new();
        for frame in 0..6 {
            scene.camera.time = f64::from(frame) / 30.0;
            scene.camera.azimuth += 1.0;
            let (drawn, count) = allocations(|| renderer.render(&scene));
            assert_eq!(drawn.unwrap().size, [16, 16]);
            counted.push(count);
        }
        println!("allocations of the frames of {name}: {counted:?}, at most {OF_A_FRAME} after the first two");
        assert!(counted[2..].iter().all(|count| *count <= OF_A_FRAME), "{name}: {counted:?}");
    }
}
