//! A render of `caustica view`, in a thread of its own.

use super::ViewArguments;
use super::event::{Event, EventQueue};
use super::orbit::orbited_camera;
use super::preview::render_preview;
use super::scene::{LoadedScene, ReadScene, problem_of_report, read_scene};
use crate::cli::plan;
use crate::cli::settings::settings_from_arguments;
use crate::integrate::{
    Algorithm, AovSurface, CameraPathSettings, Integrator, PassStage, ProgressMonitor, render_surface_aovs,
};
use crate::render::{
    EndReason, MemoryError, RenderResult, RenderedLayers, StopCriteria, check_layered_picture_memory,
    check_photon_memory, render,
};
use crate::scene::Scene;
use crate::view::{LiveRender, Orbit, Phase, PlanReport};
use miette::Report;
use rayon::ThreadPool;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Time that the camera must rest after the user has moved it, before pilots begin.
const SETTLING_TIME: Duration = Duration::from_millis(300);

/// Time between two looks for requests of surface AOVs while a render is paused.
const SURFACE_INTERVAL: Duration = Duration::from_millis(100);

/// Number of rays of each pixel for surface AOVs of the page.
const SURFACE_RAYS: u32 = 4;

/// Flags by which the session controls a job.
#[derive(Debug, Default)]
struct JobControl {
    /// True if the render must pause after the current pass; false again on resume.
    interrupted: AtomicBool,
    /// True if the job must end for good, without finishing the current pass.
    cancelled: AtomicBool,
}

/// Handle by which the session controls a job.
#[derive(Debug)]
pub(super) struct JobHandle {
    control: Arc<JobControl>,
    /// Sender that wakes a paused job. If it is dropped, a paused job ends.
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
    /// Read the scene file. The given scene is reused if only its camera differs from the file.
    File(Option<Arc<LoadedScene>>),
    /// A scene that an earlier job has read.
    Loaded(Arc<LoadedScene>),
}

/// Data of the session that each of its jobs receives.
#[derive(Clone, Copy)]
pub(super) struct JobContext<'a> {
    pub arguments: &'a ViewArguments,
    pub pool: &'a ThreadPool,
    pub events: &'a EventQueue,
    /// Lock that a job holds while it runs pilots and passes, so that two renders never use memory
    /// at the same time.
    pub render_lock: &'a Mutex<()>,
}

/// A render of `caustica view` in its own thread, from reading its scene to its end.
pub(super) struct Job<'a> {
    context: JobContext<'a>,
    live: LiveRender<'a>,
    orbit: Orbit,
    control: Arc<JobControl>,
    resumed: Receiver<()>,
}

impl<'a> Job<'a> {
    /// Makes a job that publishes to `live`, and the handle that controls it. `orbit` is the
    /// movement of the camera relative to that of the scene file.
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
        let scene = &loaded.resolved.scene;
        let moved = orbited_camera(scene, loaded.up_vector(), self.orbit);
        match moved.map(|camera| scene.with_camera(&camera)) {
            Some(moved) => self.render(&moved),
            None => self.render(scene),
        }
    }

    fn is_cancelled(&self) -> bool {
        self.control.cancelled.load(Ordering::Relaxed)
    }

    /// Shows on the page why the scene does not fit into memory, and sets the phase to failed.
    fn publish_memory_error(&self, error: MemoryError) {
        let problem = problem_of_report(&Report::new(error));
        self.live.publish(|state, _| {
            Arc::make_mut(&mut state.source).problems = vec![problem];
            state.status.source_revision += 1;
            state.status.phase = Phase::Failed;
        });
    }

    /// Renders a preview of `scene`, then runs pilots and renders the picture pass by pass.
    fn render(&mut self, scene: &Scene) {
        let JobContext { arguments, pool, render_lock, .. } = self.context;
        let (algorithm, size) = (arguments.method.integrator, scene.camera().size());
        let mut settings = settings_from_arguments(&arguments.method, arguments.effects.effects);
        settings.camera_paths.estimate_error = algorithm != Algorithm::Raycast;
        settings.camera_paths.groups_light = arguments.light_groups;
        let camera_paths = settings.camera_paths.clone();
        let free = || arguments.scene.memory_limit().available_bytes();
        let layers = RenderedLayers {
            error: camera_paths.estimate_error,
            groups: camera_paths.groups_light,
            aovs: true,
            ..RenderedLayers::default()
        };
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
        let picture_bytes = match check_layered_picture_memory(size, layers, free()) {
            Ok(picture_bytes) => picture_bytes,
            Err(error) => return self.publish_memory_error(error),
        };
        self.live.set_phase(Phase::Pilots);
        let integrator = pool.install(|| algorithm.prepare(scene, settings));
        if let Err(error) = check_photon_memory(integrator.expected_photons(), picture_bytes, free()) {
            return self.publish_memory_error(error);
        }
        self.render_passes(scene, &camera_paths, integrator.as_ref(), algorithm);
    }

    /// Publishes surface AOVs of `scene` if a browser has asked for them.
    fn publish_wanted_surfaces(
        live: &LiveRender<'_>,
        scene: &Scene,
        settings: &CameraPathSettings,
        integrator: &dyn Integrator,
        monitor: &JobMonitor<'_>,
    ) {
        live.publish_wanted_surfaces(scene.camera().size(), || {
            let effects = integrator.plan().simulated_effects();
            render_surface_aovs(scene, effects, settings, AovSurface::FirstNonSpecular, SURFACE_RAYS, monitor)
        });
    }

    /// Renders passes until the job is cancelled. The render pauses when it reaches its limits.
    /// Once it is resumed, it has no limits.
    fn render_passes(
        &mut self,
        scene: &Scene,
        settings: &CameraPathSettings,
        integrator: &dyn Integrator,
        algorithm: Algorithm,
    ) {
        let size = scene.camera().size();
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
                render(rendered, 0..u32::MAX, integrator, &stop, &JobMonitor(&control), |standing| {
                    live.after_pass(standing, &stop);
                    Self::publish_wanted_surfaces(live, scene, settings, integrator, &JobMonitor(&control));
                })
            });
            if self.is_cancelled() {
                return;
            }
            // Drop resume requests from before the pause, so that they do not end it.
            while self.resumed.try_recv().is_ok() {}
            let is_stopped = rendered.end_reason == EndReason::Interrupted;
            self.live.publish_end(&rendered, if is_stopped { Phase::Stopped } else { Phase::Ended });
            loop {
                match self.resumed.recv_timeout(SURFACE_INTERVAL) {
                    Ok(()) => break,
                    Err(RecvTimeoutError::Disconnected) => return,
                    Err(RecvTimeoutError::Timeout) => pool.install(|| {
                        let monitor = JobMonitor(&control);
                        Self::publish_wanted_surfaces(&self.live, scene, settings, integrator, &monitor);
                    }),
                }
            }
            if !is_stopped {
                stop = unlimited;
            }
        }
    }
}
