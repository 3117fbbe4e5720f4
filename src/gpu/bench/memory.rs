//! The most memory that the process has held.

/// Lets the record begin anew, where the system can; else it holds what was most since the start of the program.
pub(super) fn forget_peak() {
    #[cfg(target_os = "linux")]
    if let Err(e) = std::fs::write("/proc/self/clear_refs", "5") {
        tracing::debug!("the peak of the memory is that since the program's start: {e}");
    }
}

/// The most memory held, bytes; none where the system does not say.
pub(super) fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| 1024 * kib)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn the_peak_notices_what_was_held() {
        super::forget_peak();
        let before = super::peak().unwrap();
        let held = std::hint::black_box(vec![1u8; 64 << 20]);
        assert!(super::peak().unwrap() >= before + (60 << 20), "{before} bytes before {} more", held.len());
    }
}
