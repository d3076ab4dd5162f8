//! A render of `caustica view`, in a thread of its own.

use super::ViewArguments;
use super::event::{Event, EventQueue};
use super::orbit::orbited_camera;
use super::preview::render_preview;
use super::scene::{LoadedScene, ReadScene, problem_of_report, read_scene};
use crate::cli::plan;
use crate::cli::settings::settings_from_arguments;
use crate::integrate::{Algorithm, Integrator, PassStage, ProgressMonitor};
use crate::render::{
    EndReason, MemoryError, RenderResult, StopCriteria, check_error_estimate_memory, check_photon_memory,
    check_picture_memory, continue_render,
};
use crate::scene::Scene;
use crate::view::{LiveRender, Orbit, Phase, PlanReport};
use miette::Report;
use rayon::ThreadPool;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Time without another movement of the camera, after which pilots begin.
const SETTLING_TIME: Duration = Duration::from_millis(300);

/// Flags by which the session controls a job.
#[derive(Debug, Default)]
struct JobControl {
    /// True if the render must pause after the current pass.
    interrupted: AtomicBool,
    /// True if the job must end.
    cancelled: AtomicBool,
}

/// Handle by which the session controls a job.
#[derive(Debug)]
pub(super) struct JobHandle {
    control: Arc<JobControl>,
    /// Wakes a paused job. A paused job ends once this is dropped.
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

    /// Ends the job. Its thread drops the current pass, but finishes pilots.
    pub fn cancel(self) {
        self.control.cancelled.store(true, Ordering::Relaxed);
        self.control.interrupted.store(true, Ordering::Relaxed);
    }
}

/// Monitor of a job's passes, which ends them once the job is cancelled.
struct JobMonitor<'a>(&'a JobControl);

impl ProgressMonitor for JobMonitor<'_> {
    fn begin_stage(&self, _: PassStage, _: u64) {}
    fn report_progress(&self, _: u64) {}

    fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(Ordering::Relaxed)
    }
}

/// The scene that a job renders.
pub(super) enum JobScene {
    /// The scene file is to be read. The given scene is reused if the file differs from it in the
    /// camera only.
    File(Option<Arc<LoadedScene>>),
    /// A scene that an earlier job has read.
    Loaded(Arc<LoadedScene>),
}

/// Data that all jobs of a session share.
#[derive(Clone, Copy)]
pub(super) struct JobContext<'a> {
    pub arguments: &'a ViewArguments,
    pub pool: &'a ThreadPool,
    pub events: &'a EventQueue,
    /// Lock that a job holds while it runs pilots and passes. So the memory of two renders is never
    /// in use at a time.
    pub render_lock: &'a Mutex<()>,
}

/// A render, from reading its scene to its end.
pub(super) struct Job<'a> {
    context: JobContext<'a>,
    live: LiveRender<'a>,
    orbit: Orbit,
    control: Arc<JobControl>,
    resumed: Receiver<()>,
}

impl<'a> Job<'a> {
    /// Makes a job that publishes to `live`, and the handle that controls it. `orbit` moves the
    /// camera.
    pub fn new(context: JobContext<'a>, live: LiveRender<'a>, orbit: Orbit) -> (JobHandle, Self) {
        let (resume, resumed) = sync_channel(1);
        let control = Arc::<JobControl>::default();
        live.publish(|state, _| state.status.orbit = orbit);
        (JobHandle { control: control.clone(), resume }, Self { context, live, orbit, control, resumed })
    }

    /// Reads the scene and renders it until the job is cancelled.
    pub fn run(mut self, scene: JobScene) {
        let JobContext { arguments, pool, events, .. } = self.context;
        let loaded = match scene {
            JobScene::Loaded(loaded) => loaded,
            JobScene::File(previous) => {
                let ReadScene { source, files, loaded } = pool.install(|| read_scene(arguments, previous.as_deref()));
                if self.is_cancelled() {
                    return;
                }
                events.try_send(Event::Read { render: self.live.render_number(), files, loaded: loaded.clone() });
                let failed = loaded.is_none();
                self.live.publish(|state, _| {
                    state.source = Arc::new(source);
                    state.status.source_revision += 1;
                    state.status.phase = if failed { Phase::Failed } else { Phase::Preview };
                });
                let Some(loaded) = loaded else { return };
                loaded
            }
        };
        let moved = orbited_camera(&loaded.scene, loaded.up_vector(), self.orbit);
        match moved.map(|camera| loaded.scene.with_camera(&camera)) {
            Some(scene) => self.render(&scene),
            None => self.render(&loaded.scene),
        }
    }

    fn is_cancelled(&self) -> bool {
        self.control.cancelled.load(Ordering::Relaxed)
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

    /// Renders a preview of `scene`, and then the picture.
    fn render(&mut self, scene: &Scene) {
        let JobContext { arguments, pool, render_lock, .. } = self.context;
        let (algorithm, size) = (arguments.method.integrator, scene.camera().size());
        let mut settings = settings_from_arguments(&arguments.method, arguments.effects.effects);
        settings.camera_paths.estimate_error = algorithm != Algorithm::Raycast;
        let free = || arguments.scene.memory_limit().available_bytes();
        let check =
            if settings.camera_paths.estimate_error { check_error_estimate_memory } else { check_picture_memory };
        self.live.publish(|state, _| {
            state.status.size = size;
            state.status.phase = Phase::Preview;
        });
        if algorithm != Algorithm::Raycast {
            let control = self.control.clone();
            let (preview_size, pixels) = pool.install(|| render_preview(scene, &settings, &JobMonitor(&control)));
            if self.is_cancelled() {
                return;
            }
            self.live.show_preview(preview_size, &pixels);
        }
        // While the camera is dragged, previews are enough.
        if self.orbit != Orbit::default()
            && self.resumed.recv_timeout(SETTLING_TIME) == Err(RecvTimeoutError::Disconnected)
        {
            return;
        }
        let _render_lock = render_lock.lock().unwrap_or_else(PoisonError::into_inner);
        if self.is_cancelled() {
            return;
        }
        let pictures = match check(1, size, free()) {
            Ok(pictures) => pictures,
            Err(error) => return self.publish_memory_error(error),
        };
        self.live.set_phase(Phase::Pilots);
        let integrator = pool.install(|| algorithm.prepare(scene, settings));
        if let Err(error) = check_photon_memory(integrator.expected_photons(), pictures, free()) {
            return self.publish_memory_error(error);
        }
        self.render_passes(integrator.as_ref(), algorithm, size);
    }

    /// Renders passes until the job is cancelled. The render pauses when it reaches its limits.
    /// Once it is resumed, it has no limits.
    fn render_passes(&mut self, integrator: &dyn Integrator, algorithm: Algorithm, size: (u32, u32)) {
        let control = self.control.clone();
        let JobContext { arguments, pool, .. } = self.context;
        let limited = arguments.limits().stop_criteria(algorithm, integrator, &control.interrupted);
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
            rendered = pool.install(|| {
                continue_render(rendered, 0..u32::MAX, integrator, &stop, &JobMonitor(&control), |standing| {
                    live.after_pass(standing, &stop);
                })
            });
            if self.is_cancelled() {
                return;
            }
            // Drop resume requests from before the pause, so that they do not end it.
            while self.resumed.try_recv().is_ok() {}
            let is_stopped = rendered.ended == EndReason::Interrupted;
            self.live.publish_end(&rendered, if is_stopped { Phase::Stopped } else { Phase::Ended });
            if self.resumed.recv().is_err() {
                return;
            }
            if !is_stopped {
                stop = unlimited;
            }
        }
    }
}
