//! How much memory may be taken.

/// What holds the memory that may be taken, asked before it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Memory {
    /// Nothing: whoever asks knows how much it takes.
    #[default]
    Unbounded,
    /// What the system has free.
    System,
    /// So many bytes for the whole process.
    Limit(u64),
}

/// Bytes that a process comes to hold besides what it is asked for: code that runs for the first time, stacks, what the allocator keeps.
/// Measured: 2 MB with 2 threads, 3 MB with 64.
const BESIDES: u64 = 4_000_000;

impl Memory {
    /// Bytes that may be taken now, where that is known: of a limit what this process does not hold yet and will not need besides, else
    /// what can be had without swapping. Where the system tells neither (all but Linux), a limit holds for each thing alone.
    #[must_use]
    pub fn free(self) -> Option<u64> {
        match self {
            Self::Unbounded => None,
            Self::System => kib("/proc/meminfo", "MemAvailable:"),
            Self::Limit(bytes) => Some(bytes.saturating_sub(BESIDES + kib("/proc/self/status", "VmRSS:").unwrap_or(0))),
        }
    }
}

/// Largest resident memory of this process so far \[bytes], where the system tells (Linux).
#[must_use]
pub fn peak_memory() -> Option<u64> {
    kib("/proc/self/status", "VmHWM:")
}

/// The bytes that a line of a system's file tells in units of 1024.
fn kib(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

/// Bytes in words.
#[must_use]
pub fn bytes(n: u64) -> String {
    if n < 1_000_000_000 { format!("{:.1} MB", n as f64 * 1e-6) } else { format!("{:.1} GB", n as f64 * 1e-9) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_told_in_the_unit_that_fits() {
        assert_eq!([0, 99_940_000, 999_949_999, 1_000_000_000].map(bytes), ["0.0 MB", "99.9 MB", "999.9 MB", "1.0 GB"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_machine_tells_its_memory() {
        // More than this process holds, less than 2^60.
        assert!((1 << 20..1 << 60).contains(&Memory::System.free().unwrap()));
        assert_eq!((Memory::Unbounded.free(), Memory::Limit(1).free()), (None, Some(0)));
        let (held, left) = (peak_memory().unwrap(), Memory::Limit(1 << 50).free().unwrap());
        assert!(left < 1 << 50 && left >= (1 << 50) - BESIDES - held);
    }
}
