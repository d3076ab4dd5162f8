//! Signals that interrupt a command.
//!
//! The first SIGINT, SIGTERM or SIGHUP ends the work after the current pass and writes the
//! outputs. A signal that comes more than a second later ends the process at once. Both give the
//! exit code [`Exit::Interrupted`].

use super::Exit;
use super::progress::{clear_progress_bar, print_message};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time after the first signal within which further signals are ignored, because they stem from the
/// same interruption.
///
/// When a terminal closes, for example, both the shell and the system send SIGHUP.
const SAME_INTERRUPTION_TIME: Duration = Duration::from_secs(1);

/// Message that says what a render still does after the first interrupting signal, or after a stop
/// request of the live page.
pub(super) const STOP_CONSEQUENCE: &str = "the picture so far is written after this pass";

/// True after the first interrupting signal, or after a stop request of the live page of
/// `--listen`.
pub(super) static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Starts to handle signals.
///
/// `consequence` says what the command still does after the first signal, such as "the picture so
/// far is written after this pass".
pub(super) fn listen_for_signals(consequence: &'static str) {
    let mut first = None;
    spawn_signal_handler(move || match act_on_signal(&mut first, Instant::now()) {
        SignalAction::FinishPass => {
            INTERRUPTED.store(true, Ordering::Relaxed);
            print_message(&format!("interrupted: {consequence}; interrupt again to stop at once"));
        }
        SignalAction::Ignore => {}
        SignalAction::EndProcess => {
            clear_progress_bar();
            std::process::exit(i32::from(Exit::Interrupted as u8));
        }
    });
}

/// Ends the work after the current pass, because a user asked for it on the live page.
/// `consequence` says what the command still does, as for [`listen_for_signals`].
///
/// A later signal counts as a first signal, because the user of the terminal may not know of the
/// request.
#[cfg(feature = "view")]
pub(super) fn stop_on_request(consequence: &str) {
    if !INTERRUPTED.swap(true, Ordering::Relaxed) {
        print_message(&format!("stopped on the live page: {consequence}"));
    }
}

/// Reaction to an interrupting signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SignalAction {
    /// End the work after the current pass, and write the outputs.
    FinishPass,
    /// Do nothing: the signal stems from the same interruption as the first one.
    Ignore,
    /// End the process at once, without writing outputs.
    EndProcess,
}

/// Returns the reaction to a signal at the time `now`. `first` is the time of the first signal;
/// this function sets it if it is `None`.
fn act_on_signal(first: &mut Option<Instant>, now: Instant) -> SignalAction {
    match *first {
        None => {
            *first = Some(now);
            SignalAction::FinishPass
        }
        Some(first) if now.duration_since(first) <= SAME_INTERRUPTION_TIME => SignalAction::Ignore,
        Some(_) => SignalAction::EndProcess,
    }
}

/// Starts a thread that calls `handle` for each interrupting signal.
///
/// SIGTERM and SIGHUP stay ignored in a process that was started with them ignored (`nohup`).
/// Where the system does not report which signals are ignored (all but Linux), SIGHUP keeps its
/// default action. If no handler can be installed, a signal ends the process at once.
#[cfg(unix)]
fn spawn_signal_handler(mut handle: impl FnMut() + Send + 'static) {
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

/// Returns a bit mask of the signals that this process ignores: bit n − 1 stands for signal n.
/// Returns `None` if the system does not tell.
#[cfg(unix)]
fn ignored_signals() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

/// Starts a thread that calls `handle` for each Ctrl-C.
#[cfg(not(unix))]
fn spawn_signal_handler(handle: impl FnMut() + Send + 'static) {
    let _ = ctrlc::set_handler(handle);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_signal_ends_process_only_after_one_second() {
        let start = Instant::now();
        let mut first = None;
        let mut act = |seconds: f64| act_on_signal(&mut first, start + Duration::from_secs_f64(seconds));
        assert_eq!(act(0.0), SignalAction::FinishPass);
        assert_eq!((act(0.01), act(0.9)), (SignalAction::Ignore, SignalAction::Ignore));
        assert_eq!(act(1.1), SignalAction::EndProcess);
    }
}
