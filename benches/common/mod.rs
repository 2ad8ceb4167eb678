//! Shared by the benches: the device, and numbers with their spread.

#![allow(dead_code, reason = "each bench uses its part of this")]

use hypertexture::gpu::{Gpu, Options};
use std::fmt;

/// The device without validation, and a line that says which it is.
pub fn open() -> Gpu {
    let device = std::env::var("HYPERTEXTURE_DEVICE").ok().filter(|name| !name.is_empty());
    let gpu = Gpu::new(&Options { device, validation: false, cache: None }).unwrap();
    let info = gpu.info();
    let cores = std::thread::available_parallelism().map_or(0, std::num::NonZero::get);
    println!("device {} ({}, Vulkan {}), {cores} cores, validation off", info.name, info.driver, info.api);
    gpu
}

/// Median of repeats, and how far they lie apart.
#[derive(Clone, Copy)]
pub struct Spread {
    pub median: f64,
    pub low: f64,
    pub high: f64,
}

impl Spread {
    pub fn of(mut values: Vec<f64>) -> Spread {
        values.sort_by(f64::total_cmp);
        Spread { median: values[values.len() / 2], low: values[0], high: values[values.len() - 1] }
    }

    /// The quotients of measurements that were made side by side.
    pub fn ratio(above: &[f64], below: &[f64]) -> Spread {
        Spread::of(above.iter().zip(below).map(|(a, b)| a / b).collect())
    }
}

impl fmt::Display for Spread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (digits, width) = (f.precision().unwrap_or(1), f.width().unwrap_or(0));
        let text = format!("{:.digits$} ({:.digits$}-{:.digits$})", self.median, self.low, self.high);
        write!(f, "{text:>width$}")
    }
}
