//! Clock that measures processor time and wall time together.

use crate::stats::cpu_seconds;
use std::ops::{AddAssign, Sub};
use std::time::Instant;

/// A point in time or a duration, on the processor clock and on the wall clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuWallTime {
    /// Processor time of all threads \[s]; wall time if the system does not report it.
    pub cpu_seconds: f64,
    /// Wall-clock time \[s].
    pub wall_seconds: f64,
}

impl Sub for CpuWallTime {
    type Output = Self;

    fn sub(self, o: Self) -> Self {
        Self { cpu_seconds: self.cpu_seconds - o.cpu_seconds, wall_seconds: self.wall_seconds - o.wall_seconds }
    }
}

impl AddAssign for CpuWallTime {
    fn add_assign(&mut self, o: Self) {
        self.cpu_seconds += o.cpu_seconds;
        self.wall_seconds += o.wall_seconds;
    }
}

/// Function that returns the current time. Tests pass a synthetic clock instead of the system's.
pub(super) type ClockFn<'c> = Box<dyn Fn() -> CpuWallTime + 'c>;

/// Returns a clock that reads the operating system's times. Its wall time counts from this call.
pub(super) fn system_clock() -> ClockFn<'static> {
    let start = Instant::now();
    Box::new(move || {
        let wall = start.elapsed().as_secs_f64();
        CpuWallTime { cpu_seconds: cpu_seconds().unwrap_or(wall), wall_seconds: wall }
    })
}

/// Runs `work`; returns its result and the time that it took.
pub(super) fn measure_time<T>(clock: &dyn Fn() -> CpuWallTime, work: impl FnOnce() -> T) -> (T, CpuWallTime) {
    let before = clock();
    let done = work();
    (done, clock() - before)
}

/// Returns a description of this machine, such as `AMD EPYC, 8 threads`.
///
/// The name of the processor is known only on Linux. Elsewhere, its architecture is given instead.
pub(super) fn machine_description(threads: usize) -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let name = model.map_or(std::env::consts::ARCH, |(_, name)| name.trim());
    format!("{name}, {threads} {}", if threads == 1 { "thread" } else { "threads" })
}
