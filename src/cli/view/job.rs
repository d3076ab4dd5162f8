//! A render of `caustica view`, in a thread of its own.

use super::ViewArguments;
use crate::cli::check::quick_scene_warnings;
use crate::cli::plan;
use crate::cli::progress::InputFileCollector;
use crate::cli::scene::load_scene_and_file;
use crate::cli::settings::settings_from_arguments;
use crate::format::{SceneError, SceneReadError};
use crate::integrate::{Algorithm, Integrator, SilentMonitor};
use crate::render::{
    EndReason, MemoryError, RenderResult, StopCriteria, check_error_estimate_memory, check_photon_memory,
    check_picture_memory, continue_render,
};
use crate::scene::Scene;
use crate::view::{LiveRender, Phase, PlanReport, SceneProblem, SceneSource};
use miette::Report;
use rayon::ThreadPool;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Longest text of a scene file that the page shows \[bytes].
const MAX_SOURCE_BYTES: u64 = 1 << 20;

/// Flags by which the session controls a job.
#[derive(Debug, Default)]
struct JobControl {
    /// True to pause after the current pass.
    interrupted: AtomicBool,
    /// True to end the job.
    cancelled: AtomicBool,
}

/// Session's end of a job.
#[derive(Debug)]
pub(super) struct JobHandle {
    control: Arc<JobControl>,
    /// Wakes a paused job. A job ends once this is dropped and it is cancelled.
    resume: SyncSender<()>,
}

impl JobHandle {
    /// Pauses the render after the current pass.
    pub fn stop(&self) {
        self.control.interrupted.store(true, Ordering::Relaxed);
    }

    /// Continues a paused render.
    pub fn resume(&self) {
        self.control.interrupted.store(false, Ordering::Relaxed);
        // A full queue means that the job is about to resume anyway.
        let _ = self.resume.try_send(());
    }

    /// Ends the job. Its thread may still finish its current work, whose result is dropped.
    pub fn cancel(self) {
        self.control.cancelled.store(true, Ordering::Relaxed);
        self.control.interrupted.store(true, Ordering::Relaxed);
    }
}

/// A render, from reading its scene to its end.
pub(super) struct Job<'a> {
    arguments: &'a ViewArguments,
    pool: &'a ThreadPool,
    live: LiveRender<'a>,
    control: Arc<JobControl>,
    resumed: Receiver<()>,
}

/// A scene that was read, with its text for the page.
struct LoadedScene {
    scene: Arc<Scene>,
    source: SceneSource,
}

impl<'a> Job<'a> {
    /// Makes a job that publishes to `live`, and the handle that controls it.
    pub fn new(arguments: &'a ViewArguments, pool: &'a ThreadPool, live: LiveRender<'a>) -> (JobHandle, Self) {
        let (resume, resumed) = sync_channel(1);
        let control = Arc::<JobControl>::default();
        (JobHandle { control: control.clone(), resume }, Self { arguments, pool, live, control, resumed })
    }

    /// Reads the scene and renders it until the job is cancelled.
    pub fn run(mut self) {
        let loaded = self.pool.install(|| load_scene(self.arguments));
        match loaded {
            Ok(LoadedScene { scene, source }) => {
                self.publish_source(source);
                self.render(&scene);
            }
            Err(source) => {
                self.publish_source(source);
                self.live.set_phase(Phase::Failed);
            }
        }
    }

    fn is_cancelled(&self) -> bool {
        self.control.cancelled.load(Ordering::Relaxed)
    }

    /// Publishes the text of the scene file.
    fn publish_source(&self, source: SceneSource) {
        self.live.publish(|state, _| {
            state.source = Arc::new(source);
            state.status.source_revision += 1;
        });
    }

    /// Publishes the reason why the scene does not fit into memory.
    fn publish_memory_error(&self, error: MemoryError) {
        let problem = problem_of_report(&Report::new(error));
        self.live.publish(|state, _| {
            Arc::make_mut(&mut state.source).problems = vec![problem];
            state.status.source_revision += 1;
            state.status.phase = Phase::Failed;
        });
    }

    /// Renders `scene`. Waits after each end until the render is resumed or cancelled.
    fn render(&mut self, scene: &Scene) {
        let arguments = self.arguments;
        let (algorithm, size) = (arguments.method.integrator, scene.camera().size());
        let mut settings = settings_from_arguments(&arguments.method, arguments.effects.effects);
        settings.camera_paths.estimate_error = algorithm != Algorithm::Raycast;
        let free = || arguments.scene.memory_limit().available_bytes();
        let check =
            if settings.camera_paths.estimate_error { check_error_estimate_memory } else { check_picture_memory };
        let pictures = match check(1, size, free()) {
            Ok(pictures) => pictures,
            Err(error) => return self.publish_memory_error(error),
        };
        if self.is_cancelled() {
            return;
        }
        self.live.set_phase(Phase::Pilots);
        let integrator = self.pool.install(|| algorithm.prepare(scene, settings));
        if let Err(error) = check_photon_memory(integrator.expected_photons(), pictures, free()) {
            return self.publish_memory_error(error);
        }
        self.render_passes(integrator.as_ref(), algorithm, size);
    }

    /// Renders passes until the job is cancelled. A render that reaches its limits pauses. Once it
    /// is resumed, it has no limits.
    fn render_passes(&mut self, integrator: &dyn Integrator, algorithm: Algorithm, size: (u32, u32)) {
        let control = self.control.clone();
        let limited = self.arguments.limits().stop_criteria(algorithm, integrator, &control.interrupted);
        let unlimited = StopCriteria {
            // A second pass of ray casting would repeat the first.
            passes: (algorithm == Algorithm::Raycast).then_some(1),
            ..StopCriteria::unlimited(&control.interrupted)
        };
        let mut stop = limited;
        let mut rendered = RenderResult::without_passes(integrator, size);
        while !self.is_cancelled() {
            self.live.begin_passes(PlanReport::new(integrator.plan(), plan::pass_work_lines(integrator)), &stop, size);
            let live = &mut self.live;
            rendered = self.pool.install(|| {
                continue_render(rendered, 0..u32::MAX, integrator, &stop, &SilentMonitor, |standing| {
                    live.after_pass(standing, &stop);
                })
            });
            if self.is_cancelled() {
                return;
            }
            let is_stopped = rendered.ended == EndReason::Interrupted;
            self.live.end(&rendered, if is_stopped { Phase::Stopped } else { Phase::Ended });
            if self.resumed.recv().is_err() {
                return;
            }
            if !is_stopped {
                stop = unlimited;
            }
        }
    }
}

/// Reads the scene of the command line.
///
/// # Errors
/// The text of the scene file with its errors.
fn load_scene(arguments: &ViewArguments) -> Result<LoadedScene, SceneSource> {
    let path = &arguments.scene.scene;
    let name = path.display().to_string();
    let inputs = InputFileCollector::new(&());
    match load_scene_and_file(&arguments.scene, &inputs) {
        Ok((file, scene)) => {
            let text = file.source.text();
            let text = if text.len() as u64 <= MAX_SOURCE_BYTES { text } else { "" };
            let warnings = quick_scene_warnings(&file, &scene, &arguments.scene);
            let source = SceneSource { name, text: text.into(), problems: Vec::new(), warnings };
            Ok(LoadedScene { scene: Arc::new(scene), source })
        }
        Err(failure) => {
            let problems = failure.reports.iter().flat_map(problems_of_report).collect();
            Err(SceneSource { name, text: text_of_file(path).into(), problems, warnings: Vec::new() })
        }
    }
}

/// Returns the text of a file; empty if it is too long, or no text.
fn text_of_file(path: &std::path::Path) -> String {
    let is_short = std::fs::metadata(path).is_ok_and(|data| data.is_file() && data.len() <= MAX_SOURCE_BYTES);
    if is_short { std::fs::read_to_string(path).unwrap_or_default() } else { String::new() }
}

/// Returns the errors of a scene file that a report holds.
fn problems_of_report(report: &Report) -> Vec<SceneProblem> {
    let error = match report.downcast_ref::<SceneReadError>() {
        Some(SceneReadError::Language(error)) => Some(error),
        Some(SceneReadError::Unreadable { .. } | SceneReadError::Memory { .. }) => None,
        None => report.downcast_ref::<SceneError>(),
    };
    let Some(first) = error else { return vec![problem_of_report(report)] };
    let problem = |error: &SceneError| SceneProblem {
        line: error.line(),
        column: error.column(),
        message: error.message().to_owned(),
        remedy: error.remedy().to_owned(),
    };
    std::iter::once(first).chain(first.further_errors()).map(problem).collect()
}

/// Returns an error without a position.
fn problem_of_report(report: &Report) -> SceneProblem {
    let causes: Vec<String> = report.chain().map(ToString::to_string).collect();
    let remedy = report.help().map_or(String::new(), |help| help.to_string());
    SceneProblem { line: 0, column: 0, message: causes.join(": "), remedy }
}
