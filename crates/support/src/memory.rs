//! Memory left to this process. Allocating more makes the system kill processes without a message.

use std::fs;

/// Bytes available to this process, if known: the least of the machine's, the control group's and its own address space.
pub fn available() -> Option<u64> {
    let of_machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| of_machine(&text));
    let [most, now, uses] =
        ["max", "current", "stat"].map(|name| fs::read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok());
    let of_group = most.zip(now).zip(uses).and_then(|((most, now), uses)| of_group(&most, &now, &uses));
    of_machine.into_iter().chain(of_group).chain(addresses()).min()
}

/// Bytes of address space left to this process, if limited (`ulimit -v`).
pub fn addresses() -> Option<u64> {
    #[cfg(target_os = "linux")]
    {
        const PAGE: u64 = 4096; // or more
        let most = rustix::process::getrlimit(rustix::process::Resource::As).current?;
        let text = fs::read_to_string("/proc/self/statm").ok()?;
        let pages: u64 = text.split(' ').next()?.parse().ok()?;
        Some(most.saturating_sub(pages * PAGE))
    }
    #[cfg(not(target_os = "linux"))]
    None
}

/// Bytes available in a control group, counting its page cache as available.
fn of_group(most: &str, now: &str, uses: &str) -> Option<u64> {
    let bytes = |text: &str| text.trim().parse::<u64>().ok(); // `max` means no limit
    let files = uses.lines().find_map(|line| bytes(line.strip_prefix("file ")?)).unwrap_or_default();
    Some((bytes(most)? + files).saturating_sub(bytes(now)?))
}

/// `MemAvailable` of `/proc/meminfo`, in bytes.
fn of_machine(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_is_parsed() {
        assert_eq!(of_machine("MemTotal:  9 kB\nMemAvailable:   20 kB\nBuffers: 7 kB\n"), Some(20 << 10));
        assert_eq!(of_machine("MemTotal:  9 kB\n"), None);
        assert_eq!(of_group("100\n", "90\n", "anon 20\nfile 70\nfile_dirty 3\n"), Some(80));
        assert_eq!(of_group("max\n", "90\n", "file 70\n"), None);
        assert!(available().is_none_or(|bytes| bytes > 1 << 20), "this test itself takes more");
    }
}
