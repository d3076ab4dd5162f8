//! Interrupts: the first asks for an end after the pass, the second ends at once.

use super::Exit;
use super::progress::tell;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user asked for an end.
pub(super) static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Listens from now on; `kept` names what an interrupt once does not lose.
pub(super) fn listen(kept: &'static str) {
    // Without a handler an interrupt ends the program at once, which loses a picture but nothing else.
    let _ = ctrlc::set_handler(move || {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(Exit::Interrupted as u8));
        }
        tell(&format!("interrupted: {kept} so far is written after this pass; interrupt again to stop at once"));
    });
}
