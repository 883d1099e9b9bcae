//! What the system says of this process: processor time and main memory. Only Linux says it; elsewhere everything is `None`.

/// Ticks a second of the times in `/proc`: Linux counts in these on all processors that there is a Vulkan driver for.
const TICKS_PER_SECOND: f64 = 100.0;

/// Fields of `/proc/self/stat` between the command's name and the processor times.
const FIELDS_BEFORE_TIMES: usize = 11;

/// Seconds of processor time so far, all threads together.
pub(super) fn cpu_seconds() -> Option<f64> {
    cpu_seconds_in(&std::fs::read_to_string("/proc/self/stat").ok()?)
}

fn cpu_seconds_in(stat: &str) -> Option<f64> {
    // The name stands in brackets and may hold anything, brackets too.
    let fields = stat.rsplit_once(')')?.1.split_whitespace().skip(FIELDS_BEFORE_TIMES);
    let times: Option<Vec<f64>> = fields.take(2).map(|ticks| ticks.parse().ok()).collect();
    times.filter(|times| times.len() == 2).map(|times| times.iter().sum::<f64>() / TICKS_PER_SECOND)
}

/// Largest resident set since the process began, or since [`forget_peak`], in bytes.
pub(super) fn peak_bytes() -> Option<u64> {
    bytes_in(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// The resident set, in bytes.
pub(super) fn resident_bytes() -> Option<u64> {
    bytes_in(&std::fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Lets [`peak_bytes`] begin again from what is resident now. Whether the system allows it.
pub(super) fn forget_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

fn bytes_in(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_linux_says_is_read() {
        let stat = "42 (a) b) S 1 42 42 0 -1 4194560 100 0 0 0 250 50 7 7 20 0 9 0 1 1 1";
        assert_eq!(cpu_seconds_in(stat), Some(3.0));
        assert_eq!(cpu_seconds_in("42 (a) S 1"), None);
        let status = "Name:\tterrane\nVmHWM:\t    1500 kB\nVmRSS:\t 12 kB\n";
        assert_eq!(
            (bytes_in(status, "VmHWM:"), bytes_in(status, "VmRSS:"), bytes_in(status, "VmX:")),
            (Some(1_536_000), Some(12_288), None)
        );
    }
}
