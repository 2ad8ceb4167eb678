use super::suite::{Row, library};
use super::timed::measure;
use hypertexture::gpu::{Gpu, Options};
use hypertexture::scene::preset;
use hypertexture_support::faults::{self, fail_after};
use hypertexture_support::validation_lock::ValidationLock;
use std::cell::Cell;

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_hang_costs_a_row_and_opens_another_device() {
    let _lock = ValidationLock::acquire();
    faults::turn_on();
    let row = |name: &str| {
        let mut scene = preset("lit").unwrap();
        (scene.image.size, scene.quality.samples) = ([16, 16], 16);
        Row::picture(name.into(), scene)
    };
    let (groups, library, opened) = ([vec![row("first")], vec![row("second")]], library(), Cell::new(0));
    let open = || {
        opened.set(opened.get() + 1);
        Gpu::new(&Options::from_env())
    };
    // Faults begin with the second row: how often the peaks are measured depends on the load of the machine.
    let run = |left: usize| {
        let gpu = Gpu::new(&Options::from_env()).unwrap();
        let arm = |part: f32| {
            if part < 0.75 {
                fail_after(left);
            }
        };
        let found = measure(gpu, &open, &library, &groups, 1, &arm, &|| false);
        (found, faults::stop().0)
    };
    let (whole, calls) = run(usize::MAX);
    assert_eq!((whole.rows.len(), whole.failures.len(), opened.get()), (2, 0, 0));
    let waits: Vec<usize> = (0..calls.len()).filter(|call| calls[*call] == "vkWaitForFences").collect();
    let (found, _) = run(*waits.last().unwrap());
    let [failure] = found.failures.as_slice() else { panic!("{:?}", found.failures) };
    assert!(failure.starts_with("second: ") && failure.contains("did not finish"), "{failure}");
    assert_eq!(opened.get(), 1, "another device");
    assert_eq!(found.rows.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["first"]);
}
