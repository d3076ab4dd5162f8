//! Progress: a bar on a terminal, plain lines elsewhere.

use super::outlook::duration_text;
use crate::format::mesh::{MeshReadMonitor, TriangleMesh};
use crate::integrate::{Monitor, Stage};
use crate::stats::Counters;
use indicatif::{HumanCount, ProgressBar, ProgressState, ProgressStyle};
use std::fmt;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// The bar of this process, which messages must not overwrite.
static BAR: OnceLock<ProgressBar> = OnceLock::new();

/// Writes a line to the standard error, above the progress bar if there is one.
///
/// A failed write is ignored: a reader that has gone away must not end a render.
pub(super) fn print_message(line: &str) {
    let write = || {
        let _ = writeln!(std::io::stderr(), "{line}");
    };
    match BAR.get() {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// Removes the progress bar from the terminal.
pub(super) fn clear_bar() {
    if let Some(bar) = BAR.get() {
        bar.finish_and_clear();
    }
}

/// Warns of samples and photons that were not finite. A correct render rejects none.
pub(super) fn warn_of_rejected(counters: &Counters) {
    for (n, what) in [(counters.rejected_samples, "samples"), (counters.rejected_photons, "photons")] {
        if n > 0 {
            print_message(&format!("warning: {n} {what} were not finite and were left out"));
        }
    }
}

/// Shows how far a command is.
pub(super) enum Progress {
    /// Shows nothing.
    Quiet,
    /// Prints lines.
    Lines(Mutex<State>),
    /// Draws a bar.
    Bar(ProgressBar, Mutex<State>),
}

/// State that the labels of the bar show.
#[derive(Debug, Default)]
pub(super) struct State {
    /// Label of the pass, such as `pass 3/20`.
    pass: String,
    /// Estimated end of the whole render.
    end: Option<Instant>,
    /// Triangles of all meshes read so far.
    triangles: usize,
}

impl Progress {
    pub fn new(quiet: bool) -> Self {
        if quiet {
            Self::Quiet
        } else if std::io::stderr().is_terminal() {
            Self::Bar(BAR.get_or_init(|| ProgressBar::new(0)).clone(), Mutex::default())
        } else {
            Self::Lines(Mutex::default())
        }
    }

    /// True if the progress is shown as plain lines.
    pub fn has_lines(&self) -> bool {
        matches!(self, Self::Lines(_))
    }

    /// Prints a line that stays.
    pub fn say(&self, line: &str) {
        match self {
            Self::Quiet => {}
            Self::Lines(_) | Self::Bar(..) => print_message(line),
        }
    }

    /// Labels the stages from now on with pass `pass`, counted from 1, of `of` passes if known.
    pub fn pass(&self, pass: u32, of: Option<u32>) {
        let label = match of {
            Some(of) => format!("pass {pass}/{of}"),
            None => format!("pass {pass}"),
        };
        self.state().into_iter().for_each(|mut state| state.pass.clone_from(&label));
    }

    /// Sets the time that the whole render still needs; `None` if it is not known.
    pub fn set_time_left(&self, left: Option<Duration>) {
        let end = left.and_then(|left| Instant::now().checked_add(left));
        self.state().into_iter().for_each(|mut state| state.end = end);
    }

    /// Shows a note beside the bar.
    pub fn note(&self, note: String) {
        if let Self::Bar(bar, _) = self {
            bar.set_message(note);
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Self::Bar(bar, _) = self {
            bar.finish_and_clear();
        }
    }

    fn state(&self) -> Option<MutexGuard<'_, State>> {
        match self {
            Self::Quiet => None,
            Self::Lines(state) | Self::Bar(_, state) => Some(state.lock().unwrap_or_else(PoisonError::into_inner)),
        }
    }

    /// Starts the bar anew.
    fn start(&self, style: Result<ProgressStyle, indicatif::style::TemplateError>, prefix: String, total: u64) {
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

/// The rate of a stage: `12,345 paths/s`.
fn rate_label(unit: &'static str) -> impl Fn(&ProgressState, &mut dyn fmt::Write) + Clone {
    move |state, out| {
        let _ = write!(out, "{} {unit}/s", HumanCount(state.per_sec().round() as u64));
    }
}

/// The time left: of the whole render if its end is known, else of the stage.
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

impl Monitor for Progress {
    fn begin(&self, stage: Stage, total: u64) {
        let (name, unit) = match stage {
            Stage::Photons => ("photons", "paths"),
            Stage::Indexing => ("indexing", "photons"),
            Stage::Camera => ("image", "pixels"),
        };
        let Some((pass, end)) = self.state().map(|state| (state.pass.clone(), state.end)) else { return };
        let template = format!("{{prefix}} {name:<8} {{bar:16}} {{percent:>3}} %  {{rate}}  {{left}}  {{wide_msg}}");
        let style = ProgressStyle::with_template(&template);
        let style = style.map(|style| style.with_key("rate", rate_label(unit)).with_key("left", time_left_label(end)));
        self.start(style, pass, total);
    }

    fn advance(&self, units: u64) {
        if let Self::Bar(bar, _) = self {
            bar.inc(units);
        }
    }
}

/// Least number of triangles of a mesh that gets a line of its own.
const LARGE_MESH: usize = 1_000_000;

impl MeshReadMonitor for Progress {
    fn begin(&self, path: &Path, bytes: u64) {
        let style = ProgressStyle::with_template("reading {prefix} {bar:16} {percent:>3} %  {rate}");
        let style = style.map(|style| {
            style.with_key("rate", |state: &ProgressState, out: &mut dyn fmt::Write| {
                let _ = write!(out, "{:.0} MB/s", 1e-6 * state.per_sec());
            })
        });
        self.start(style, path.display().to_string(), bytes);
    }

    fn advance(&self, bytes: u64) {
        if let Self::Bar(bar, _) = self {
            bar.inc(bytes);
        }
    }

    /// Reports a large mesh, and shows that its triangles are indexed until another stage begins.
    fn end(&self, path: &Path, mesh: &TriangleMesh) {
        let n = mesh.triangles.len();
        if n >= LARGE_MESH {
            self.say(&format!("read {}: {n} triangles", path.display()));
        }
        let Some(triangles) = self.state().map(|mut state| {
            state.triangles += n;
            state.triangles
        }) else {
            return;
        };
        let template = "indexing {prefix} triangles {spinner}  {elapsed}";
        self.start(ProgressStyle::with_template(template), HumanCount(triangles as u64).to_string(), 0);
        if let Self::Bar(bar, _) = self {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
    }
}

/// A [`MeshReadMonitor`] that shows progress and collects the files that a scene names.
pub(super) struct InputFiles<'a> {
    progress: &'a dyn MeshReadMonitor,
    files: Mutex<Vec<PathBuf>>,
}

impl<'a> InputFiles<'a> {
    pub fn new(progress: &'a dyn MeshReadMonitor) -> Self {
        Self { progress, files: Mutex::default() }
    }

    /// The files that were named, in the order of reading.
    pub fn into_files(self) -> Vec<PathBuf> {
        self.files.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MeshReadMonitor for InputFiles<'_> {
    fn names(&self, path: &Path) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_owned());
    }

    fn begin(&self, path: &Path, bytes: u64) {
        self.progress.begin(path, bytes);
    }

    fn advance(&self, bytes: u64) {
        self.progress.advance(bytes);
    }

    fn end(&self, path: &Path, mesh: &TriangleMesh) {
        self.progress.end(path, mesh);
    }
}
