//! Signals that interrupt a command.
//!
//! The first SIGINT, SIGTERM or SIGHUP ends the work after the current pass and writes the
//! outputs. The second one ends the process at once. Both give the exit code
//! [`Exit::Interrupted`].

use super::Exit;
use super::progress::{clear_progress_bar, print_message};
use std::sync::atomic::{AtomicBool, Ordering};

/// True after the first interrupting signal, or after a stop request of the live page of
/// `--listen`.
pub(super) static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Starts to handle signals.
///
/// `consequence` says what the command still does after the first signal, such as "the picture so
/// far is written after this pass".
pub(super) fn listen_for_signals(consequence: &'static str) {
    spawn_signal_handler(move || {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            clear_progress_bar();
            std::process::exit(i32::from(Exit::Interrupted as u8));
        }
        print_message(&format!("interrupted: {consequence}; interrupt again to stop at once"));
    });
}

/// Starts a thread that calls `handle` for each interrupting signal.
///
/// SIGTERM and SIGHUP stay ignored in a process that was started with them ignored (`nohup`).
/// Where the system does not report which signals are ignored (all but Linux), SIGHUP keeps its
/// default action. If no handler can be installed, a signal ends the process at once.
#[cfg(unix)]
fn spawn_signal_handler(handle: impl Fn() + Send + 'static) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored_signals();
    let is_ignored = |signal: i32, unknown: bool| ignored.map_or(unknown, |mask| mask >> (signal - 1) & 1 == 1);
    let mut handled = vec![SIGINT];
    handled
        .extend([(SIGTERM, false), (SIGHUP, true)].into_iter().filter(|(s, or)| !is_ignored(*s, *or)).map(|(s, _)| s));
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(handled) {
        std::thread::spawn(move || signals.forever().for_each(|_| handle()));
    }
}

/// Returns the signals that this process ignores; `None` if unknown. Bit `n - 1` stands for signal
/// `n`.
#[cfg(unix)]
fn ignored_signals() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

/// Starts a thread that calls `handle` for each Ctrl-C.
#[cfg(not(unix))]
fn spawn_signal_handler(handle: impl Fn() + Send + 'static) {
    let _ = ctrlc::set_handler(handle);
}
