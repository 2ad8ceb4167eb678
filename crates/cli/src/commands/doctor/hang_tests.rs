//! A device that does not answer, and a signal.

use super::bench::Bench;
use super::probes::LOOPS;
use crate::session::stop_flag;
use hypertexture::gpu::{Gpu, GpuError, Options, ending};
use hypertexture::shader::{self, Linker};
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Set in the process that waits for the device.
const CHILD: &str = "HYPERTEXTURE_TEST_HANG";

/// Draws for minutes; a signal ends the wait.
#[test]
#[ignore = "a child process of the other test"]
fn waits_for_a_device() {
    if std::env::var_os(CHILD).is_none() {
        return;
    }
    let stop = stop_flag().unwrap();
    let gpu = Gpu::new(&Options::from_env()).unwrap();
    let bench = Bench { gpu: &gpu, library: shader::shipped(), linker: Linker::new().unwrap() };
    println!("\nwaits");
    let error = bench.draw(&LOOPS).map(|_| ()).unwrap_err().to_string();
    println!("\n{error} {}", stop.load(Ordering::Relaxed));
    assert_eq!(error, GpuError::Interrupted { what: "self-test".into() }.to_string());
    ending::finish(0);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
#[cfg(target_os = "linux")]
fn a_signal_ends_a_wait_for_a_device() {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "commands::doctor::hang_tests::waits_for_a_device", "--ignored", "--nocapture"])
        .env(CHILD, "1")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line == "waits"), "the device was not opened");
    let asked = Instant::now();
    std::thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "the draw takes minutes");
    assert!(Command::new("kill").arg(child.id().to_string()).status().unwrap().success());
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let ended = asked.elapsed().saturating_sub(Duration::from_millis(300));
    println!("ended {:.2} s after the signal", ended.as_secs_f64());
    assert!(ended < Duration::from_secs(3), "the signal waited for the device: {ended:?}");
    assert!(said.contains(&"interrupted: the device had not finished `self-test` true".into()), "{said:?}");
}
