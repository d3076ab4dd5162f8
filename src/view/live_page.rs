//! Newest state of a render: the render publishes it, and the web server reads it.

use super::frame::LiveFrame;
use super::status::{FrameReport, LiveStatus, SceneSource};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use tokio::sync::watch;

/// State of a render at one moment: status, picture, error maps and scene text.
#[derive(Clone, Debug, Default)]
pub struct LiveState {
    /// Progress, limits and estimated error of the render, as browsers receive them.
    pub status: LiveStatus,
    /// The newest picture or preview; `None` before the first one.
    pub picture: Option<Arc<LiveFrame>>,
    /// The newest maps of the estimated error; `None` before the first ones.
    pub error_maps: Option<Arc<LiveFrame>>,
    /// Surface AOVs; `None` until a browser asks for them.
    pub surface_aovs: Option<Arc<LiveFrame>>,
    /// Text of the scene file, with its errors.
    pub source: Arc<SceneSource>,
}

/// A published state of the render, with its JSON for browsers.
#[derive(Debug, Default)]
pub(super) struct PublishedState {
    pub state: LiveState,
    json: OnceLock<Arc<str>>,
}

impl PublishedState {
    /// Returns the [`LiveStatus`] as JSON. It is encoded once for all browsers.
    pub fn json(&self) -> Arc<str> {
        let encode = || serde_json::to_string(&self.state.status).unwrap_or_default().into();
        self.json.get_or_init(encode).clone()
    }
}

/// Place where a render publishes its newest state, and from which the web server reads that state.
///
/// Publishing replaces one pointer, so readers never delay the render. A slow reader skips states:
/// when the reader is ready again, it takes the newest state.
#[derive(Debug)]
pub struct LivePage {
    /// Working copy of the newest state. A publication changes this copy, then sends a clone to
    /// readers.
    newest: Mutex<LiveState>,
    sender: watch::Sender<Arc<PublishedState>>,
    /// True if a browser has asked for error maps since the render last looked for such requests.
    wants_error_maps: AtomicBool,
    /// True if a browser has asked for surface AOVs since the render last looked for such requests.
    wants_surface_aovs: AtomicBool,
    /// Reference picture with which the page compares the render; `None` without `--reference`.
    reference: Option<Arc<LiveFrame>>,
}

impl LivePage {
    /// Makes a page for renders of the scene file `scene` by the algorithm `integrator`.
    ///
    /// `interactive` is true for `caustica view`, whose page can move the camera. `reference` is a
    /// picture with which the page compares the render.
    #[must_use]
    pub fn new(scene: String, integrator: &'static str, interactive: bool, reference: Option<LiveFrame>) -> Self {
        let status = LiveStatus {
            version: env!("CARGO_PKG_VERSION"),
            scene,
            integrator,
            interactive,
            reference_size: reference.as_ref().map(|frame| frame.size),
            ..LiveStatus::default()
        };
        let newest = LiveState { status, ..LiveState::default() };
        let sender = watch::Sender::new(Arc::new(PublishedState { state: newest.clone(), json: OnceLock::new() }));
        let reference = reference.map(Arc::new);
        let (wants_maps, wants_surfaces) = Default::default();
        Self {
            newest: Mutex::new(newest),
            sender,
            wants_error_maps: wants_maps,
            wants_surface_aovs: wants_surfaces,
            reference,
        }
    }

    /// Begins another render and returns its number. From then on, publications of earlier renders
    /// are ignored.
    ///
    /// The page keeps the old picture until this render publishes one.
    pub fn begin_render(&self) -> u32 {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let old = &newest.status;
        newest.status = LiveStatus {
            version: old.version,
            scene: old.scene.clone(),
            integrator: old.integrator,
            interactive: old.interactive,
            reference_size: old.reference_size,
            render_number: old.render_number + 1,
            sequence: old.sequence,
            size: old.size,
            picture: old.picture.clone(),
            source_revision: old.source_revision,
            problem_count: old.problem_count,
            ..LiveStatus::default()
        };
        newest.error_maps = None;
        newest.surface_aovs = None;
        let render = newest.status.render_number;
        self.publish_state(&mut newest);
        render
    }

    /// Applies `change` to the newest state and publishes the state. Does nothing if a render with
    /// a larger number than `render` has begun.
    ///
    /// The second argument of `change` is the sequence number of this update. A frame that `change`
    /// adds must carry this number.
    pub fn publish(&self, render: u32, change: impl FnOnce(&mut LiveState, u32)) {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        if newest.status.render_number == render {
            let sequence = newest.status.sequence + 1;
            change(&mut newest, sequence);
            self.publish_state(&mut newest);
        }
    }

    fn publish_state(&self, newest: &mut LiveState) {
        newest.status.sequence += 1;
        newest.status.picture = newest.picture.as_deref().map(FrameReport::new);
        newest.status.error_maps = newest.error_maps.as_deref().map(FrameReport::new);
        newest.status.surface_aovs = newest.surface_aovs.as_deref().map(FrameReport::new);
        newest.status.problem_count = newest.source.problems.len();
        self.sender.send_replace(Arc::new(PublishedState { state: newest.clone(), json: OnceLock::new() }));
    }

    /// Returns true if a browser has asked for error maps since the last call of this function. The
    /// request then counts as handled.
    pub fn take_error_map_request(&self) -> bool {
        self.wants_error_maps.swap(false, Ordering::Relaxed)
    }

    /// Asks the render to publish maps of the estimated error.
    pub(super) fn request_error_maps(&self) {
        self.wants_error_maps.store(true, Ordering::Relaxed);
    }

    /// Returns true if a browser has asked for surface AOVs since the last call of this function.
    /// The request then counts as handled.
    pub fn take_surface_aov_request(&self) -> bool {
        self.wants_surface_aovs.swap(false, Ordering::Relaxed)
    }

    /// Asks the render to publish surface AOVs.
    pub(super) fn request_surface_aovs(&self) {
        self.wants_surface_aovs.store(true, Ordering::Relaxed);
    }

    /// Returns a channel that delivers the newest state after each publication.
    pub(super) fn subscribe(&self) -> watch::Receiver<Arc<PublishedState>> {
        self.sender.subscribe()
    }

    /// Returns the newest published state.
    pub(super) fn newest_state(&self) -> Arc<PublishedState> {
        self.sender.borrow().clone()
    }

    /// Returns the reference picture that the page compares with the render; `None` without
    /// `--reference`.
    pub(super) fn reference(&self) -> Option<&LiveFrame> {
        self.reference.as_deref()
    }

    /// Returns the number of browsers that follow the state of the render.
    #[must_use]
    pub fn reader_count(&self) -> usize {
        self.sender.receiver_count()
    }
}
