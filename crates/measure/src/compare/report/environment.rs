//! Where and when something was measured. It names no file, no folder and no person.

use super::command_line;
use hypertexture::gpu::Gpu;
use serde::{Deserialize, Serialize};
use std::time::{SystemTime, UNIX_EPOCH};

/// Where and when something was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Date and time, UTC.
    pub date: String,
    /// Version of this crate.
    pub version: String,
    /// Name of the device.
    pub device: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Vulkan version of the device.
    pub vulkan: String,
    /// Model of the processor, where the system tells it.
    pub processor: Option<String>,
    /// Threads that this process may run on.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// Load average of the last minute at the start, where the system tells it.
    pub load_before: Option<f64>,
    /// The same at the end.
    pub load_after: Option<f64>,
    /// How the processor chooses its clock, where the system tells it.
    pub governor: Option<String>,
    /// Variables that change how fast lavapipe is, and their values.
    pub variables: Vec<(String, String)>,
    /// The command line, by [`command_line`].
    #[serde(default)]
    pub command: String,
}

/// Variables of Mesa that decide how fast lavapipe draws.
const VARIABLES: [&str; 4] = ["LP_NUM_THREADS", "LP_NATIVE_VECTOR_WIDTH", "GALLIVM_PERF", "MESA_SHADER_CACHE_DISABLE"];

impl Environment {
    /// That of now; `load_after` is still open.
    pub fn of(gpu: &Gpu) -> Environment {
        let info = gpu.info();
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let variable = |name: &str| Some((name.to_string(), std::env::var(name).ok()?));
        Environment {
            date: date(seconds),
            version: env!("CARGO_PKG_VERSION").into(),
            device: info.name.clone(),
            driver: info.driver.clone(),
            vulkan: info.api.clone(),
            processor: processor(),
            threads: std::thread::available_parallelism().map_or(1, |count| count.get()),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            load_before: load(),
            load_after: None,
            governor: read("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor").map(|text| text.trim().into()),
            variables: VARIABLES.into_iter().filter_map(variable).collect(),
            command: command_line(std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned())),
        }
    }
}

/// Load average of the last minute, where the system tells it.
pub fn load() -> Option<f64> {
    read("/proc/loadavg")?.split(' ').next()?.parse().ok()
}

fn processor() -> Option<String> {
    let text = read("/proc/cpuinfo")?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}

fn read(path: &str) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// Seconds since 1970 as date and time, UTC (Hinnant, days from civil, reversed).
fn date(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let of_month = of_year - (153 * month + 2) / 5 + 1;
    let (month, carry) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let year = era * 400 + year + carry;
    format!("{year}-{month:02}-{of_month:02} {:02}:{:02} UTC", rest / 3600, rest / 60 % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(date(0), "1970-01-01 00:00 UTC");
        assert_eq!(date(951_782_399), "2000-02-28 23:59 UTC");
        assert_eq!(date(951_868_799), "2000-02-29 23:59 UTC");
        assert_eq!(date(1_763_742_960), "2025-11-21 16:36 UTC");
    }
}
