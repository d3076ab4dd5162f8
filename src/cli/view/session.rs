//! Session of `caustica view`: starts a render thread whenever the scene or the camera changes, and
//! forwards requests of the page to this thread.

use super::ViewArguments;
use super::event::{Event, EventQueue};
use super::job::{Job, JobContext, JobHandle, JobScene};
use super::scene::LoadedScene;
use super::watch::{FileWatch, WatchedFiles};
use crate::cli::interrupt::INTERRUPTED;
use crate::view::{LivePage, Orbit, RenderPublisher, Request};
use rayon::ThreadPool;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex};
use std::thread::{self, Scope};
use std::time::{Duration, Instant};

/// Longest time between two checks for interrupting signals and for changed files.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// One run of `caustica view`: it starts a [`Job`] whenever the scene or the camera changes.
pub(super) struct Session<'a> {
    arguments: &'a ViewArguments,
    page: &'a LivePage,
    pool: &'a ThreadPool,
    queue: EventQueue,
    render_lock: Mutex<()>,
}

/// Mutable state of a session of `caustica view`: the current render job, and data for later jobs.
struct SessionState {
    job: JobHandle,
    /// Number by which the live page identifies the render of the current job.
    render_number: u32,
    /// True while the current job reads the scene file.
    reading: bool,
    /// The scene that was read last without an error.
    loaded: Option<Arc<LoadedScene>>,
    watch: FileWatch,
    /// Position of the camera that the user has chosen on the page, relative to the camera of the
    /// scene file.
    orbit: Orbit,
    /// True if the user has moved the camera since the current job was started.
    orbit_changed: bool,
}

impl<'a> Session<'a> {
    /// Makes a session whose renders run in `pool` and appear on `page`. The jobs of the session
    /// send their events to `queue`.
    pub fn new(arguments: &'a ViewArguments, page: &'a LivePage, pool: &'a ThreadPool, queue: EventQueue) -> Self {
        Self { arguments, page, pool, queue, render_lock: Mutex::new(()) }
    }

    /// Renders until the first interrupting signal. `events` receives the events that browsers and
    /// jobs send to the session's queue.
    pub fn run(&self, events: &Receiver<Event>) {
        thread::scope(|scope| {
            let mut watch = FileWatch::default();
            watch.set_files(WatchedFiles::new(&self.arguments.scene.scene));
            let orbit = Orbit::default();
            let (render, job) = self.start_job(scope, JobScene::File(None), orbit);
            let mut state = SessionState {
                job,
                render_number: render,
                reading: true,
                loaded: None,
                watch,
                orbit,
                orbit_changed: false,
            };
            let mut next_poll = Instant::now() + POLL_INTERVAL;
            while !INTERRUPTED.load(Ordering::Relaxed) {
                let first = events.recv_timeout(next_poll.saturating_duration_since(Instant::now()));
                // Handle all queued events before a job is started, because only the last of
                // several camera movements counts.
                first.into_iter().chain(events.try_iter()).for_each(|event| state.handle_event(event));
                let mut next_scene = state.scene_for_moved_camera();
                if Instant::now() >= next_poll {
                    next_poll = Instant::now() + POLL_INTERVAL;
                    if state.watch.has_settled_change() {
                        next_scene = Some(JobScene::File(state.loaded.clone()));
                    }
                }
                if let Some(scene) = next_scene {
                    state.orbit_changed = false;
                    state.reading = matches!(scene, JobScene::File(_));
                    let (render, job) = self.start_job(scope, scene, state.orbit);
                    state.render_number = render;
                    std::mem::replace(&mut state.job, job).cancel();
                }
            }
            state.job.cancel();
        });
    }

    /// Starts a thread that renders `scene` as another job. Returns the number by which the page
    /// identifies this render, and the handle of the job.
    fn start_job<'scope>(
        &'scope self,
        scope: &'scope Scope<'scope, '_>,
        scene: JobScene,
        orbit: Orbit,
    ) -> (u32, JobHandle) {
        let live = RenderPublisher::begin(self.page, Instant::now());
        let number = live.render_number();
        let (handle, job) = Job::new(self.job_context(), live, orbit);
        scope.spawn(move || job.run(scene));
        (number, handle)
    }

    /// Returns the references to session data that each job receives.
    fn job_context(&self) -> JobContext<'_> {
        JobContext { arguments: self.arguments, pool: self.pool, events: &self.queue, render_lock: &self.render_lock }
    }
}

impl SessionState {
    /// Handles one event. Forwards a stop or resume request of the live page to the current job.
    /// Stores a requested camera position, and the scene that the current job has read.
    fn handle_event(&mut self, event: Event) {
        match event {
            Event::Request(Request::Stop) => self.job.pause(),
            Event::Request(Request::Resume) => self.job.resume(),
            Event::Request(Request::Orbit(orbit)) => {
                self.orbit_changed |= orbit != self.orbit;
                self.orbit = orbit;
            }
            Event::SceneRead { render, files, loaded } => {
                if render == self.render_number {
                    self.reading = false;
                    self.watch.set_files(files);
                    self.loaded = loaded.or(self.loaded.take());
                }
            }
        }
    }

    /// Returns the scene that a new job renders if the user has moved the camera. Returns `None` if
    /// the camera has not moved, or no scene has been read.
    ///
    /// Also returns `None` while the current job reads the scene file. A new job with the earlier
    /// scene would cancel this reading, and the user's edit of the file would be lost.
    fn scene_for_moved_camera(&self) -> Option<JobScene> {
        self.loaded.clone().filter(|_| self.orbit_changed && !self.reading).map(JobScene::Loaded)
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene::read_scene;
    use super::*;
    use crate::cli::{Arguments, Command};
    use clap::Parser;

    const SCENE: &str = "\
PerspectiveCamera { center 0 0 3 lookAt 0 0 0 angle 40 width 4 height 3 }
Lights { PointLight { position 0 6 0  intensity 60 60 60 } }
Group { }
";

    #[test]
    fn camera_moves_wait_for_a_scene_being_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        std::fs::write(&path, SCENE).unwrap();
        let parsed = Arguments::try_parse_from(["caustica", "view", path.to_str().unwrap()]).unwrap();
        let Command::View(arguments) = parsed.command else { panic!("another command") };
        let earlier = read_scene(&arguments, None);
        let page = LivePage::new(String::new(), "hybrid", true, None);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (queue, _events) = EventQueue::new();
        let session = Session::new(&arguments, &page, &pool, queue);
        let live = RenderPublisher::begin(&page, Instant::now());
        let render_number = live.render_number();
        let (job, _) = Job::new(session.job_context(), live, Orbit::default());
        let (watch, orbit) = (FileWatch::default(), Orbit::default());
        let loaded = earlier.loaded;
        let mut state = SessionState { job, render_number, reading: true, loaded, watch, orbit, orbit_changed: true };
        assert!(state.loaded.is_some() && state.scene_for_moved_camera().is_none());
        let edited = read_scene(&arguments, None);
        let loaded = edited.loaded.clone();
        state.handle_event(Event::SceneRead { render: render_number, files: edited.files, loaded });
        let Some(JobScene::Loaded(next)) = state.scene_for_moved_camera() else { panic!("no scene") };
        assert!(Arc::ptr_eq(&next, &edited.loaded.unwrap()));
    }
}
