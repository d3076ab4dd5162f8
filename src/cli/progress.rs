//! Progress: bars on a terminal, plain lines elsewhere.

use crate::format::mesh::{ReadMonitor, TriangleMesh};
use crate::integrate::{Monitor, Stage};
use crate::stats::Counters;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::Mutex;

/// Writes a line to the standard error. A reader that has gone away must not end a render, so failure is of no account.
pub(super) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Warns of what a render left out, which should be nothing.
pub(super) fn tell_of_rejected(counters: &Counters) {
    for (n, what) in [(counters.rejected_samples, "samples"), (counters.rejected_photons, "photons")] {
        if n > 0 {
            tell(&format!("warning: {n} {what} were not finite and were left out"));
        }
    }
}

/// Shows how far a render is.
pub(super) enum Progress {
    Quiet,
    Lines,
    Bars { phase: ProgressBar, prefix: Mutex<String> },
}

impl Progress {
    pub fn new(quiet: bool) -> Self {
        if quiet {
            Self::Quiet
        } else if std::io::stderr().is_terminal() {
            Self::Bars { phase: ProgressBar::new(0), prefix: Mutex::new(String::new()) }
        } else {
            Self::Lines
        }
    }

    /// A line that stays.
    pub fn say(&self, line: &str) {
        match self {
            Self::Quiet => {}
            Self::Lines => tell(line),
            Self::Bars { phase, .. } => phase.suspend(|| tell(line)),
        }
    }

    /// A pass begins; `of` is how many there will be, where that is known.
    pub fn pass(&self, pass: u32, of: Option<u32>) {
        let label = match of {
            Some(of) => format!("pass {pass}/{of}"),
            None => format!("pass {pass}"),
        };
        if let Self::Bars { prefix, .. } = self
            && let Ok(mut prefix) = prefix.lock()
        {
            *prefix = label;
        }
    }

    /// What there is to say of the passes so far, beside the bar.
    pub fn note(&self, note: String) {
        if let Self::Bars { phase, .. } = self {
            phase.set_message(note);
        }
    }

    /// Clears the bars.
    pub fn finish(&self) {
        if let Self::Bars { phase, .. } = self {
            phase.finish_and_clear();
        }
    }
}

impl Monitor for Progress {
    fn begin(&self, phase: Stage, total: u64) {
        let Self::Bars { phase: bar, prefix } = self else { return };
        let (name, unit) = match phase {
            Stage::Photons => ("photons", "paths"),
            Stage::Indexing => ("trees", "photons"),
            Stage::Camera => ("image", "pixels"),
        };
        let template =
            format!("{{prefix}} {name:<8} {{bar:28}} {{percent:>3}} %  {{per_sec}} {unit}  {{eta}} left  {{msg}}");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
        if let Ok(prefix) = prefix.lock() {
            bar.set_prefix(prefix.clone());
        }
        bar.set_length(total);
        bar.reset();
    }

    fn advance(&self, units: u64) {
        if let Self::Bars { phase, .. } = self {
            phase.inc(units);
        }
    }
}

/// Triangles of a mesh whose reading takes long enough to be told of.
const MANY: usize = 1_000_000;

impl ReadMonitor for Progress {
    fn begin(&self, path: &Path, bytes: u64) {
        let Self::Bars { phase: bar, .. } = self else { return };
        let template = "reading {prefix} {bar:28} {percent:>3} %  {binary_bytes_per_sec}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_prefix(path.display().to_string());
        bar.set_length(bytes);
        bar.reset();
    }

    fn advance(&self, bytes: u64) {
        if let Self::Bars { phase, .. } = self {
            phase.inc(bytes);
        }
    }

    fn end(&self, path: &Path, mesh: &TriangleMesh) {
        if let Self::Bars { phase, .. } = self {
            phase.set_length(0);
            phase.reset();
        }
        if mesh.triangles.len() >= MANY {
            self.say(&format!("read {}: {} triangles", path.display(), mesh.triangles.len()));
        }
    }
}
