//! Memory limits, and measurement of the memory that this process uses.

use std::sync::OnceLock;

/// Upper limit of the memory for loading a scene and rendering it. Work that needs more is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MemoryLimit {
    /// No limit.
    #[default]
    Unbounded,
    /// The memory that the system can give without swapping.
    System,
    /// A limit for the memory of the whole process \[bytes].
    ProcessBytes(u64),
}

/// Reserve \[bytes] in a memory limit for memory that is not allocated on the heap, such as code
/// and thread stacks.
///
/// With 2 threads, the resident memory exceeded the heap by 10 to 13 MB in measurements.
const RESERVED_BYTES: u64 = 14_000_000;

impl MemoryLimit {
    /// Returns the number of bytes that may still be allocated; `None` if no limit is known.
    ///
    /// Under [`MemoryLimit::ProcessBytes`], the number is the limit minus the bytes in use and a
    /// fixed reserve. It does not depend on the machine, so all machines refuse the same work.
    /// Under [`MemoryLimit::System`], it is the memory that Linux can give without swapping; other
    /// systems have no known limit.
    #[must_use]
    pub fn available_bytes(self) -> Option<u64> {
        match self {
            Self::Unbounded => None,
            Self::System => read_proc_bytes("/proc/meminfo", "MemAvailable:"),
            Self::ProcessBytes(limit) => Some(limit.saturating_sub(RESERVED_BYTES + memory_in_use())),
        }
    }
}

/// Functions that return the current and the peak memory of a program's global allocator. The
/// program passes them to [`set_allocation_counter`].
#[derive(Clone, Copy, Debug)]
pub struct AllocationCounter {
    /// Function that returns the number of allocated bytes that are not freed yet.
    pub bytes_in_use: fn() -> u64,
    /// Function that returns the largest value of `bytes_in_use` so far.
    pub peak_bytes: fn() -> u64,
}

static COUNTER: OnceLock<AllocationCounter> = OnceLock::new();

/// Registers functions that return the memory of this process's global allocator, for memory limits
/// and reports. Only the first call has an effect.
///
/// Without registered functions, the memory in use is unknown. On Linux, the resident anonymous
/// memory then takes its place. On other systems, it counts as 0.
pub fn set_allocation_counter(counter: AllocationCounter) {
    let _ = COUNTER.set(counter);
}

/// Returns the memory that this process uses \[bytes]. With a registered allocation counter, it is
/// the allocated memory that is not freed yet. Without one, it is the resident anonymous memory on
/// Linux, and 0 on other systems.
fn memory_in_use() -> u64 {
    COUNTER.get().map_or_else(
        || read_proc_bytes("/proc/self/status", "RssAnon:").unwrap_or(0),
        |counter| (counter.bytes_in_use)(),
    )
}

/// Returns the peak memory of this process so far \[bytes]: allocated bytes if an allocation
/// counter is registered, else resident bytes.
///
/// `None` if there is no allocation counter and the system is not Linux.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    COUNTER.get().map_or_else(|| read_proc_bytes("/proc/self/status", "VmHWM:"), |counter| Some((counter.peak_bytes)()))
}

/// Reads a size from a file in `/proc` and returns it in bytes: the number in the line that begins
/// with `key`, such as `VmHWM: 1024 kB`. Returns `None` if there is no such line.
fn read_proc_bytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

/// Returns a number of bytes as text: `512 bytes`, `3.2 kB`, `99.9 MB`, `1.0 GB`. Units are
/// decimal.
#[must_use]
pub fn format_bytes(n: u64) -> String {
    match n {
        1 => "1 byte".to_owned(),
        0..1000 => format!("{n} bytes"),
        1000..1_000_000 => format!("{:.1} kB", n as f64 * 1e-3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", n as f64 * 1e-6),
        1_000_000_000.. => format!("{:.1} GB", n as f64 * 1e-9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_use_the_unit_that_fits() {
        assert_eq!(
            [0, 1, 999, 48_000, 999_949].map(format_bytes),
            ["0 bytes", "1 byte", "999 bytes", "48.0 kB", "999.9 kB"]
        );
        assert_eq!([99_940_000, 999_949_999, 1_000_000_000].map(format_bytes), ["99.9 MB", "999.9 MB", "1.0 GB"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_machine_reports_its_memory() {
        // The available memory is at least 1 MiB (2^20 bytes), and less than 2^60 bytes.
        assert!((1 << 20..1 << 60).contains(&MemoryLimit::System.available_bytes().unwrap()));
        assert_eq!(
            (MemoryLimit::Unbounded.available_bytes(), MemoryLimit::ProcessBytes(1).available_bytes()),
            (None, Some(0))
        );
        let (held, left) = (peak_memory().unwrap(), MemoryLimit::ProcessBytes(1 << 50).available_bytes().unwrap());
        assert!(left < 1 << 50 && left >= (1 << 50) - RESERVED_BYTES - held);
    }
}
