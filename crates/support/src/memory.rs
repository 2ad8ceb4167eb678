//! How much memory is left: what is asked for beyond it ends the process, and often others, without a word.

use std::fs;

/// Bytes that this process may still take, where the system says: of the machine, of the group that it runs in, and of its own
/// addresses.
pub fn available() -> Option<u64> {
    let of_machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| of_machine(&text));
    let [most, now, uses] =
        ["max", "current", "stat"].map(|name| fs::read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok());
    let of_group = most.zip(now).zip(uses).and_then(|((most, now), uses)| of_group(&most, &now, &uses));
    of_machine.into_iter().chain(of_group).chain(addresses()).min()
}

/// Bytes of addresses that are left to this process, where they are limited (`ulimit -v`).
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

/// What is left in a group: files that are kept in memory go when it is needed.
fn of_group(most: &str, now: &str, uses: &str) -> Option<u64> {
    let bytes = |text: &str| text.trim().parse::<u64>().ok(); // no number: no limit
    let files = uses.lines().find_map(|line| bytes(line.strip_prefix("file ")?)).unwrap_or_default();
    Some((bytes(most)? + files).saturating_sub(bytes(now)?))
}

/// What is available in the text of `/proc/meminfo`.
fn of_machine(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_what_the_system_says() {
        assert_eq!(of_machine("MemTotal:  9 kB\nMemAvailable:   20 kB\nBuffers: 7 kB\n"), Some(20 << 10));
        assert_eq!(of_machine("MemTotal:  9 kB\n"), None);
        assert_eq!(of_group("100\n", "90\n", "anon 20\nfile 70\nfile_dirty 3\n"), Some(80));
        assert_eq!(of_group("max\n", "90\n", "file 70\n"), None);
        assert!(available().is_none_or(|bytes| bytes > 1 << 20), "this test itself takes more");
    }
}
