//! Events to which a session of `caustica view` reacts, and their queue.

use super::scene::LoadedScene;
use super::watch::WatchedFiles;
use crate::view::Request;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Largest number of events that wait for the session of `caustica view`. Further events are
/// refused while so many wait.
const MAX_EVENTS: usize = 64;

/// Event to which the session of `caustica view` reacts.
pub(super) enum Event {
    /// Request of a browser that shows the live page.
    Request(Request),
    /// A job has read the scene file, with or without errors.
    SceneRead {
        /// Number by which the live page identifies the render of the job, see
        /// [`RenderPublisher::render_number`](crate::view::RenderPublisher::render_number).
        render: u32,
        /// The scene file and the files that it names, with their modification times and lengths
        /// before reading.
        files: WatchedFiles,
        /// The scene that was read; `None` if it has errors.
        loaded: Option<Arc<LoadedScene>>,
    },
}

/// Sending end of the queue through which browsers and jobs send [`Event`]s to the session.
#[derive(Clone)]
pub(super) struct EventQueue(SyncSender<Event>);

impl EventQueue {
    /// Makes an empty queue. Returns its sending and its receiving end.
    pub fn new() -> (Self, Receiver<Event>) {
        let (sender, receiver) = sync_channel(MAX_EVENTS);
        (Self(sender), receiver)
    }

    /// Adds an event; returns false if the queue is full. Never waits.
    pub fn try_send(&self, event: Event) -> bool {
        self.0.try_send(event).is_ok()
    }
}
