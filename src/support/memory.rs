//! How much memory is left: what is asked for beyond it ends the process, and often others, without a word.

use std::fs;

/// Bytes that this process may still take, where the system says: of the machine, and of the group that it runs in.
pub(crate) fn available() -> Option<u64> {
    let of_machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| of_machine(&text));
    let of_group = |name: &str| fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?.trim().parse::<u64>().ok();
    let left_in_group =
        of_group("memory.max").zip(of_group("memory.current")).map(|(most, now)| most.saturating_sub(now));
    of_machine.into_iter().chain(left_in_group).min()
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
        assert!(available().is_none_or(|bytes| bytes > 1 << 20), "this test itself takes more");
    }
}
