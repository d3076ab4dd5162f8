//! Job: one render of `caustica view`, which runs in its own thread.

use super::ViewArguments;
use super::event::{Event, EventQueue};
use super::orbit::orbited_camera;
use super::preview::render_preview;
use super::scene::{LoadedScene, SceneReadResult, problem_of_report, read_scene};
use crate::cli::plan;
use crate::cli::settings::settings_from_arguments;
use crate::integrate::{
    Algorithm, AovSurface, CameraPathSettings, Integrator, PassStage, ProgressMonitor, render_surface_aovs,
};
use crate::render::{
    EndReason, LayerSelection, MemoryError, RenderResult, StopCriteria, check_layered_picture_memory,
    check_photon_memory, render,
};
use crate::scene::Scene;
use crate::view::{Orbit, PlanReport, RenderPublisher, RenderStage};
use miette::Report;
use rayon::ThreadPool;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time for which a moved camera must rest before its job begins the full render. While the user
/// drags the camera, jobs only render previews.
const SETTLING_TIME: Duration = Duration::from_millis(300);

/// Time between two checks for requested surface AOVs while a render is paused.
const AOV_POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Time between two attempts to send an event while the queue of the session is full.
const EVENT_RETRY_INTERVAL: Duration = Duration::from_millis(10);

/// Number of camera rays per pixel for the surface AOVs (albedo, normal and others) of the page.
const AOV_PIXEL_RAYS: u32 = 4;

/// Flags that pause or cancel a job, which is a render thread of `caustica view`.
#[derive(Debug, Default)]
struct JobControl {
    /// True if the render must pause after the current pass; false again on resume.
    pause_requested: AtomicBool,
    /// True if the job must end for good, without finishing the current pass.
    cancelled: AtomicBool,
}

/// Handle with which the session of `caustica view` pauses, resumes or cancels a job.
#[derive(Debug)]
pub(super) struct JobHandle {
    control: Arc<JobControl>,
    /// Sender that wakes a paused job. If the sender is dropped, the job ends instead.
    resume_sender: SyncSender<()>,
}

impl JobHandle {
    /// Pauses the render after the current pass.
    pub fn pause(&self) {
        self.control.pause_requested.store(true, Ordering::Relaxed);
    }

    /// Continues a paused render.
    pub fn resume(&self) {
        self.control.pause_requested.store(false, Ordering::Relaxed);
        // If the queue is full, the job is about to resume anyway.
        let _ = self.resume_sender.try_send(());
    }

    /// Ends the job. Its thread drops the current pass, but finishes pilots (simulations before the
    /// first pass), which cannot be cancelled.
    pub fn cancel(self) {
        self.control.cancelled.store(true, Ordering::Relaxed);
        self.control.pause_requested.store(true, Ordering::Relaxed);
    }
}

/// Progress monitor that cancels the current pass once the job is cancelled. Shows no progress.
struct JobMonitor<'a>(&'a JobControl);

impl ProgressMonitor for JobMonitor<'_> {
    fn begin_stage(&self, _: PassStage, _: u64) {}
    fn report_progress(&self, _: u64) {}

    fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(Ordering::Relaxed)
    }
}

/// Source of the scene that a job renders.
pub(super) enum JobScene {
    /// The scene file, which the job reads. Holds an earlier scene, if there is one: the job reuses
    /// parts that are unchanged since then.
    File(Option<Arc<LoadedScene>>),
    /// A scene that an earlier job has read.
    Loaded(Arc<LoadedScene>),
}

/// References to data of a session, which all its jobs share.
#[derive(Clone, Copy)]
pub(super) struct JobContext<'a> {
    pub arguments: &'a ViewArguments,
    pub pool: &'a ThreadPool,
    pub events: &'a EventQueue,
    /// Lock that a job holds while it prepares the algorithm and renders passes. So the memory of
    /// two renders is never in use at the same time.
    pub render_lock: &'a Mutex<()>,
}

/// A job of `caustica view`: one render in a thread of its own, from reading the scene until the
/// job is cancelled.
pub(super) struct Job<'a> {
    context: JobContext<'a>,
    live: RenderPublisher<'a>,
    orbit: Orbit,
    control: Arc<JobControl>,
    resume_receiver: Receiver<()>,
}

impl<'a> Job<'a> {
    /// Makes a job that publishes its render to `live`, and the handle that controls the job.
    /// `orbit` is the user's camera position, relative to the camera of the scene file.
    pub fn new(context: JobContext<'a>, live: RenderPublisher<'a>, orbit: Orbit) -> (JobHandle, Self) {
        let (resume, resumed) = sync_channel(1);
        let control = Arc::<JobControl>::default();
        live.publish(|state, _| state.status.orbit = orbit);
        (
            JobHandle { control: control.clone(), resume_sender: resume },
            Self { context, live, orbit, control, resume_receiver: resumed },
        )
    }

    /// Reads the scene and renders it until the job is cancelled.
    pub fn run(mut self, scene: JobScene) {
        let JobContext { arguments, pool, events, .. } = self.context;
        let loaded = match scene {
            JobScene::Loaded(loaded) => loaded,
            JobScene::File(previous) => {
                let SceneReadResult { source, files, loaded } =
                    pool.install(|| read_scene(arguments, previous.as_deref()));
                if self.is_cancelled() {
                    return;
                }
                let render = self.live.render_number();
                // The session waits for this event before it moves the camera.
                while !events.try_send(Event::SceneRead { render, files: files.clone(), loaded: loaded.clone() }) {
                    if self.is_cancelled() {
                        return;
                    }
                    std::thread::sleep(EVENT_RETRY_INTERVAL);
                }
                let failed = loaded.is_none();
                self.live.publish(|state, _| {
                    state.source = Arc::new(source);
                    state.status.source_revision += 1;
                    state.status.stage = if failed { RenderStage::Failed } else { RenderStage::Preview };
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

    /// Shows on the page that the scene does not fit into memory: publishes `error` and the stage
    /// [`RenderStage::Failed`].
    fn publish_memory_error(&self, error: MemoryError) {
        let problem = problem_of_report(&Report::new(error));
        self.live.publish(|state, _| {
            Arc::make_mut(&mut state.source).problems = vec![problem];
            state.status.source_revision += 1;
            state.status.stage = RenderStage::Failed;
        });
    }

    /// Renders a preview of `scene`, then prepares the algorithm and renders the picture pass by
    /// pass.
    fn render(&mut self, scene: &Scene) {
        let JobContext { arguments, pool, render_lock, .. } = self.context;
        let (algorithm, size) = (arguments.method.integrator, scene.camera().size());
        let mut settings = settings_from_arguments(&arguments.method, arguments.effects.effects);
        settings.camera_paths.estimate_error = algorithm != Algorithm::Raycast;
        settings.camera_paths.groups_light = arguments.light_groups;
        let camera_paths = settings.camera_paths.clone();
        let free = || arguments.scene.memory_limit().available_bytes();
        let layers = LayerSelection {
            estimates_error: camera_paths.estimate_error,
            groups_light: camera_paths.groups_light,
            renders_aovs: true,
            ..LayerSelection::default()
        };
        self.live.publish(|state, _| {
            state.status.size = size;
            state.status.stage = RenderStage::Preview;
        });
        if algorithm != Algorithm::Raycast {
            let control = self.control.clone();
            let (preview_size, pixels) = pool.install(|| render_preview(scene, &settings, &JobMonitor(&control)));
            if self.is_cancelled() {
                return;
            }
            self.live.show_preview(preview_size, &pixels);
        }
        // While the user drags the camera, previews are enough. So wait until the camera rests, and
        // end this job if a newer job replaces it meanwhile.
        if self.orbit != Orbit::default()
            && self.resume_receiver.recv_timeout(SETTLING_TIME) == Err(RecvTimeoutError::Disconnected)
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
        self.live.publish_stage(RenderStage::Pilots);
        let start = Instant::now();
        let integrator = pool.install(|| algorithm.prepare(scene, settings));
        if let Err(error) = check_photon_memory(integrator.expected_photons(), picture_bytes, free()) {
            return self.publish_memory_error(error);
        }
        self.render_passes(scene, &camera_paths, integrator.as_ref(), algorithm, start);
    }

    /// Publishes the surface AOVs of `scene` (albedo, normal and others) if a browser has asked for
    /// them.
    fn publish_requested_aovs(
        live: &RenderPublisher<'_>,
        scene: &Scene,
        settings: &CameraPathSettings,
        integrator: &dyn Integrator,
        monitor: &JobMonitor<'_>,
    ) {
        live.publish_wanted_surface_aovs(scene.camera().size(), || {
            let effects = integrator.plan().simulated_effects();
            render_surface_aovs(scene, effects, settings, AovSurface::FirstNonSpecular, AOV_PIXEL_RAYS, monitor)
        });
    }

    /// Renders passes until the job is cancelled. The render pauses when it reaches a limit of the
    /// command line. If the user then resumes the render, it continues without limits. `start` is
    /// the time at which the preparation of `algorithm` began.
    ///
    /// If the user stops the render before a limit, the limits stay. The time limit then counts
    /// from the moment at which the user resumes the render.
    fn render_passes(
        &mut self,
        scene: &Scene,
        settings: &CameraPathSettings,
        integrator: &dyn Integrator,
        algorithm: Algorithm,
        start: Instant,
    ) {
        let size = scene.camera().size();
        let control = self.control.clone();
        let JobContext { arguments, pool, .. } = self.context;
        let limited = arguments.limits().stop_criteria(algorithm, integrator, &control.pause_requested);
        let limited = StopCriteria { time_before_passes: start.elapsed(), ..limited };
        let unlimited = StopCriteria {
            // Ray casting needs only one pass, because a second pass would repeat the first.
            max_passes: (algorithm == Algorithm::Raycast).then_some(1),
            ..StopCriteria::unlimited(&control.pause_requested)
        };
        let mut stop = limited;
        let mut rendered = RenderResult::without_passes(integrator, size);
        while !self.is_cancelled() {
            self.live.publish_plan_and_limits(
                PlanReport::new(integrator.plan(), plan::pass_work_lines(integrator)),
                &stop,
                size,
            );
            let live = &mut self.live;
            rendered = pool.install(|| {
                render(rendered, 0..u32::MAX, integrator, &stop, &JobMonitor(&control), |standing| {
                    live.publish_pass_if_due(standing, &stop);
                    Self::publish_requested_aovs(live, scene, settings, integrator, &JobMonitor(&control));
                })
            });
            if self.is_cancelled() {
                return;
            }
            // Drop resume requests from before the pause, so that they do not end the pause.
            while self.resume_receiver.try_recv().is_ok() {}
            let is_stopped = rendered.end_reason == EndReason::Interrupted;
            if is_stopped && !control.pause_requested.load(Ordering::Relaxed) {
                // The user has resumed the render since it stopped. The request may be among those
                // that were dropped.
                stop.time_before_passes = Duration::ZERO;
                continue;
            }
            self.live.publish_end(&rendered, if is_stopped { RenderStage::Stopped } else { RenderStage::Ended });
            loop {
                match self.resume_receiver.recv_timeout(AOV_POLL_INTERVAL) {
                    Ok(()) => break,
                    Err(RecvTimeoutError::Disconnected) => return,
                    Err(RecvTimeoutError::Timeout) => pool.install(|| {
                        let monitor = JobMonitor(&control);
                        Self::publish_requested_aovs(&self.live, scene, settings, integrator, &monitor);
                    }),
                }
            }
            if is_stopped {
                stop.time_before_passes = Duration::ZERO;
            } else {
                stop = unlimited;
            }
        }
    }
}
