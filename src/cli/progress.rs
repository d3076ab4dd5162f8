//! Progress display: a bar on a terminal, plain lines elsewhere.

use super::forecast_text::duration_text;
use crate::format::mesh::{MeshReadMonitor, TriangleMesh};
use crate::integrate::{PassStage, ProgressMonitor};
use crate::stats::Counters;
use indicatif::{HumanCount, ProgressBar, ProgressState, ProgressStyle};
use std::fmt;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// The progress bar of the process. Messages are printed above it.
static PROGRESS_BAR: OnceLock<ProgressBar> = OnceLock::new();

/// Writes a line to the standard error, above the progress bar if there is one.
///
/// A failed write is ignored, so that a closed standard error does not end a render.
pub(super) fn print_message(line: &str) {
    let write = || {
        let _ = writeln!(std::io::stderr(), "{line}");
    };
    match PROGRESS_BAR.get() {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// Removes the progress bar of the process from the terminal, if there is one.
pub(super) fn clear_progress_bar() {
    if let Some(bar) = PROGRESS_BAR.get() {
        bar.finish_and_clear();
    }
}

/// Prints warnings of samples and photons that were left out as invalid: they were infinite or NaN,
/// or a photon had a negative flux. A correct render has none.
pub(super) fn warn_of_rejected_samples(counters: &Counters) {
    for (n, what) in [(counters.rejected_samples, "samples"), (counters.rejected_photons, "photons")] {
        if n > 0 {
            print_message(&format!("warning: {n} {what} were not finite and were left out"));
        }
    }
}

/// Display of a command's progress on the standard error.
pub(super) enum ProgressDisplay {
    /// Shows nothing.
    Quiet,
    /// Prints plain lines, for a standard error that is not a terminal.
    Lines(Mutex<ProgressBarLabels>),
    /// Draws a progress bar on a terminal.
    Bar(ProgressBar, Mutex<ProgressBarLabels>),
}

/// Texts, times and counts that a progress bar shows.
#[derive(Debug, Default)]
pub(super) struct ProgressBarLabels {
    /// Text about the current work, such as `pass 3/20` or `AOVs`.
    pub(super) work: String,
    /// Time at which the whole render is expected to end; `None` if unknown.
    end: Option<Instant>,
    /// Number of triangles of all meshes that were read so far.
    triangles: usize,
}

impl ProgressDisplay {
    pub fn new(quiet: bool) -> Self {
        if quiet {
            Self::Quiet
        } else if std::io::stderr().is_terminal() {
            Self::Bar(PROGRESS_BAR.get_or_init(|| ProgressBar::new(0)).clone(), Mutex::default())
        } else {
            Self::Lines(Mutex::default())
        }
    }

    /// True for [`Self::Quiet`]: neither progress nor lines are shown.
    pub fn is_quiet(&self) -> bool {
        matches!(self, Self::Quiet)
    }

    /// True if progress is printed as plain lines instead of a bar.
    pub fn uses_plain_lines(&self) -> bool {
        matches!(self, Self::Lines(_))
    }

    /// Prints a line that stays on the terminal, unless the command is quiet.
    pub fn print_line(&self, line: &str) {
        match self {
            Self::Quiet => {}
            Self::Lines(_) | Self::Bar(..) => print_message(line),
        }
    }

    /// Sets the pass number that the bar shows, such as `pass 3/20`. `pass` is counted from 1, and
    /// `total` is the number of all passes; `None` if unknown.
    pub fn set_pass_number(&self, pass: u32, total: Option<u32>) {
        let label = match total {
            Some(total) => format!("pass {pass}/{total}"),
            None => format!("pass {pass}"),
        };
        self.set_work_label(&label);
    }

    /// Sets the text about the current work that the bar shows, in place of the pass number.
    pub fn set_work_label(&self, label: &str) {
        self.lock_progress_labels().into_iter().for_each(|mut labels| label.clone_into(&mut labels.work));
    }

    /// Sets the remaining time of the whole render that the bar shows; `None` if unknown.
    pub fn set_time_left(&self, left: Option<Duration>) {
        let end = left.and_then(|left| Instant::now().checked_add(left));
        self.lock_progress_labels().into_iter().for_each(|mut labels| labels.end = end);
    }

    /// Sets the note that is shown to the right of the bar.
    pub fn set_progress_note(&self, note: String) {
        if let Self::Bar(bar, _) = self {
            bar.set_message(note);
        }
    }

    /// Removes this display's bar from the terminal; does nothing for other displays.
    pub fn remove_progress_bar(&self) {
        if let Self::Bar(bar, _) = self {
            bar.finish_and_clear();
        }
    }

    fn lock_progress_labels(&self) -> Option<MutexGuard<'_, ProgressBarLabels>> {
        match self {
            Self::Quiet => None,
            Self::Lines(state) | Self::Bar(_, state) => Some(state.lock().unwrap_or_else(PoisonError::into_inner)),
        }
    }

    /// Restarts this display's bar at zero; does nothing if the display has no bar. The bar is full
    /// after `total` units of progress, such as photon paths.
    fn restart_progress_bar(
        &self,
        style: Result<ProgressStyle, indicatif::style::TemplateError>,
        prefix: String,
        total: u64,
    ) {
        let Self::Bar(bar, _) = self else { return };
        bar.disable_steady_tick();
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.set_prefix(prefix);
        bar.set_length(total);
        bar.reset();
    }
}

/// Returns a formatter for the progress bar that writes the speed of a stage, such as
/// `12,345 paths/s`.
fn progress_rate_label(unit: &'static str) -> impl Fn(&ProgressState, &mut dyn fmt::Write) + Clone {
    move |state, out| {
        let _ = write!(out, "{} {unit}/s", HumanCount(state.per_sec().round() as u64));
    }
}

/// Returns a formatter for the progress bar that writes the time left until `end`, the expected end
/// of the render.
///
/// Without `end`, the formatter writes the remaining time of the current stage of the pass.
fn time_left_label(end: Option<Instant>) -> impl Fn(&ProgressState, &mut dyn fmt::Write) + Clone {
    move |state, out| {
        let _ = match end {
            Some(end) => {
                write!(out, "{} left", duration_text(end.saturating_duration_since(Instant::now()).as_secs_f64()))
            }
            None => write!(out, "{} left of this stage", duration_text(state.eta().as_secs_f64())),
        };
    }
}

impl ProgressMonitor for ProgressDisplay {
    fn begin_stage(&self, stage: PassStage, total: u64) {
        let (name, unit) = match stage {
            PassStage::Photons => ("photons", "paths"),
            PassStage::Indexing => ("indexing", "photons"),
            PassStage::Camera => ("image", "pixels"),
        };
        let Some((work, end)) = self.lock_progress_labels().map(|labels| (labels.work.clone(), labels.end)) else {
            return;
        };
        let template = format!("{{prefix}} {name:<8} {{bar:16}} {{percent:>3}} %  {{rate}}  {{left}}  {{wide_msg}}");
        let style = ProgressStyle::with_template(&template);
        let style =
            style.map(|style| style.with_key("rate", progress_rate_label(unit)).with_key("left", time_left_label(end)));
        self.restart_progress_bar(style, work, total);
    }

    fn report_progress(&self, units: u64) {
        if let Self::Bar(bar, _) = self {
            bar.inc(units);
        }
    }
}

/// Smallest number of triangles of a large mesh. A line reports when a large mesh has been read.
const LARGE_MESH_TRIANGLES: usize = 1_000_000;

impl MeshReadMonitor for ProgressDisplay {
    fn on_read_start(&self, path: &Path, bytes: u64) {
        let style = ProgressStyle::with_template("reading {prefix} {bar:16} {percent:>3} %  {rate}");
        let style = style.map(|style| {
            style.with_key("rate", |state: &ProgressState, out: &mut dyn fmt::Write| {
                let _ = write!(out, "{:.0} MB/s", 1e-6 * state.per_sec());
            })
        });
        self.restart_progress_bar(style, path.display().to_string(), bytes);
    }

    fn on_bytes_parsed(&self, bytes: u64) {
        if let Self::Bar(bar, _) = self {
            bar.inc(bytes);
        }
    }

    /// Shows the number of triangles of all meshes so far. Prints a line if `mesh` is large.
    fn on_read_end(&self, path: &Path, mesh: &TriangleMesh) {
        let n = mesh.triangles.len();
        if n >= LARGE_MESH_TRIANGLES {
            self.print_line(&format!("read {}: {n} triangles", path.display()));
        }
        let Some(triangles) = self.lock_progress_labels().map(|mut state| {
            state.triangles += n;
            state.triangles
        }) else {
            return;
        };
        let template = "indexing {prefix} triangles {spinner}  {elapsed}";
        self.restart_progress_bar(ProgressStyle::with_template(template), HumanCount(triangles as u64).to_string(), 0);
        if let Self::Bar(bar, _) = self {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
    }
}
