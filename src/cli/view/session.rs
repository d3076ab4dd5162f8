//! Session of `caustica view`: starts a render thread, and hands requests of the page to it.

use super::ViewArguments;
use super::job::{Job, JobHandle};
use crate::cli::interrupt::INTERRUPTED;
use crate::view::{LivePage, LiveRender, Request};
use rayon::ThreadPool;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::{self, Scope};
use std::time::{Duration, Instant};

/// Largest number of requests that wait for the session. Further ones are refused.
const MAX_REQUESTS: usize = 64;

/// Time after which the session looks for signals.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Sending end of the queue of requests.
#[derive(Debug)]
pub(super) struct RequestQueue(SyncSender<Request>);

impl RequestQueue {
    /// Makes an empty queue. Returns both ends.
    pub fn new() -> (Self, Receiver<Request>) {
        let (sender, receiver) = sync_channel(MAX_REQUESTS);
        (Self(sender), receiver)
    }

    /// Adds a request; returns false if the queue is full. Never waits.
    pub fn put(&self, request: Request) -> bool {
        self.0.try_send(request).is_ok()
    }
}

/// Session of `caustica view`.
pub(super) struct Session<'a> {
    arguments: &'a ViewArguments,
    page: &'a LivePage,
    pool: &'a ThreadPool,
    requests: Receiver<Request>,
}

impl<'a> Session<'a> {
    /// Makes a session whose renders run in `pool` and appear on `page`.
    pub fn new(
        arguments: &'a ViewArguments,
        page: &'a LivePage,
        pool: &'a ThreadPool,
        requests: Receiver<Request>,
    ) -> Self {
        Self { arguments, page, pool, requests }
    }

    /// Renders until the first interrupting signal.
    pub fn run(&self) {
        thread::scope(|scope| {
            let job = self.start_job(scope);
            while !INTERRUPTED.load(Ordering::Relaxed) {
                match self.requests.recv_timeout(POLL_INTERVAL) {
                    Ok(Request::Stop) => job.stop(),
                    Ok(Request::Resume) => job.resume(),
                    Ok(Request::Orbit(_)) | Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            }
            job.cancel();
        });
    }

    /// Starts the render thread of a new job.
    fn start_job<'scope>(&self, scope: &'scope Scope<'scope, '_>) -> JobHandle
    where
        'a: 'scope,
    {
        let live = LiveRender::begin(self.page, Instant::now());
        let (handle, job) = Job::new(self.arguments, self.pool, live);
        scope.spawn(move || job.run());
        handle
    }
}
