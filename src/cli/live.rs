//! The live page of `caustica render --listen`, and its reference picture.

use super::interrupt::{STOP_CONSEQUENCE, stop_on_request};
use super::progress::print_message;
use super::{CommandFailure, Exit, RenderArguments};
use crate::image;
use crate::view::{LiveFrame, LivePage, PageServer, RenderPublisher, Request};
use miette::Report;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Error: the reference picture of the live page cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot read the reference `{}`: {source}", path.display())]
#[diagnostic(help("name a picture in .exr, .png or .hdr format"))]
struct LiveReferenceError {
    path: PathBuf,
    source: image::ReadError,
}

/// Reads the reference picture at `path`; returns `None` if `path` is `None`.
pub(super) fn read_reference(path: Option<&Path>) -> Result<Option<LiveFrame>, CommandFailure> {
    let Some(path) = path else { return Ok(None) };
    let image = image::read(path)
        .map_err(|source| CommandFailure::new(Exit::Input, LiveReferenceError { path: path.to_owned(), source }))?;
    Ok(Some(LiveFrame::from_image(&image)))
}

/// Prints the URL of a live page, even with `--quiet`, because the secret token in the URL is shown
/// nowhere else.
pub(super) fn print_page_address(server: &PageServer) {
    print_message(&format!("live page: {}", server.url()));
}

/// Live page of `caustica render --listen`, and its web server.
pub(super) struct LiveOutput {
    page: Arc<LivePage>,
    server: PageServer,
}

impl LiveOutput {
    /// Starts the page of `--listen`; `None` without this flag.
    pub fn start(arguments: &RenderArguments) -> Result<Option<Self>, CommandFailure> {
        let Some(address) = arguments.listen else { return Ok(None) };
        let reference = read_reference(arguments.reference.as_deref())?;
        let scene = arguments.scene.scene.display().to_string();
        let page = Arc::new(LivePage::new(scene, arguments.method.integrator.name(), false, reference));
        let server = PageServer::start(address, page.clone(), Box::new(handle_page_request));
        let server = server.map_err(|error| CommandFailure::usage_error(Report::new(error)))?;
        print_page_address(&server);
        Ok(Some(Self { page, server }))
    }

    /// Begins a render on the page. `load_start` is the time at which loading of its scene began.
    pub fn begin_render(&self, load_start: Instant) -> RenderPublisher<'_> {
        RenderPublisher::begin(&self.page, load_start)
    }

    /// Ends the server of the page, after browsers have had time to fetch the last picture.
    pub fn finish(self) {
        self.server.finish();
    }
}

/// Handles a request of the live page. [`Request::Stop`] ends the render like the first Ctrl-C.
///
/// Returns false for other requests, because `caustica render` cannot resume a render or move its
/// camera.
fn handle_page_request(request: Request) -> bool {
    match request {
        Request::Stop => {
            stop_on_request(STOP_CONSEQUENCE);
            true
        }
        Request::Resume | Request::Orbit(_) => false,
    }
}
