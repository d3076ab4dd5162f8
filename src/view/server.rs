//! The web server of the live page, in a thread of its own.

use super::address::{ListenAddress, ListenError};
use super::guard::{check_request, random_token};
use super::live_page::LivePage;
use super::request::Request;
use super::responses::{
    KnownFrameQuery, SaveOptions, busy_response, layer_pixels_response, page_html, saved_picture_response,
    scene_source_response, state_events_response,
};
use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Path, Query, Request as HttpRequest, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS};
use axum::http::{HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::{Semaphore, watch};

/// Largest number of browsers that may follow the state of the render at one time.
const MAX_READERS: usize = 64;

/// Largest number of simultaneous responses with pixels. The limit bounds memory, since each
/// response may hold one frame.
const MAX_PIXEL_RESPONSES: usize = 32;

/// Largest size of the body of an HTTP request \[bytes].
const MAX_BODY_BYTES: usize = 4096;

/// Time for which the server stays open after the end of a render, so that browsers can fetch the
/// last picture.
const FINAL_FETCH_DELAY: Duration = Duration::from_millis(500);

/// Time that open connections have to finish after the server has ended. Connections that are still
/// open are then closed.
const CONNECTION_CUT_DELAY: Duration = Duration::from_millis(500);

/// Function that handles each [`Request`] of a browser, such as stopping the render. The function
/// returns false if it refuses the request. The function must not block the server's thread.
pub type RequestHandler = Box<dyn Fn(Request) -> bool + Send + Sync>;

/// Web server of the live page. The server ends when this value is dropped.
#[derive(Debug)]
pub struct PageServer {
    url: String,
    page: Arc<LivePage>,
    end: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

/// Data that the handlers of all HTTP routes share.
struct RouteState {
    page: Arc<LivePage>,
    handler: RequestHandler,
    token: String,
    port: u16,
    reader_permits: Arc<Semaphore>,
    pixel_response_permits: Arc<Semaphore>,
    end: watch::Receiver<bool>,
}

impl PageServer {
    /// Starts a server of `page` at `address`, in a thread of its own. `handler` receives the
    /// [`Request`]s of browsers.
    ///
    /// # Errors
    /// [`ListenError`] if the address is in use, or the system refuses it.
    pub fn start(address: ListenAddress, page: Arc<LivePage>, handler: RequestHandler) -> Result<Self, ListenError> {
        let ListenAddress(address) = address;
        Self::bind(address, page, handler).map_err(|source| ListenError { address, source })
    }

    fn bind(address: SocketAddr, page: Arc<LivePage>, handler: RequestHandler) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let bound = listener.local_addr()?;
        let token = random_token()?;
        let url = format!("http://{}/{token}/", SocketAddr::new(reachable_address(bound.ip()), bound.port()));
        let (end, receiver) = watch::channel(false);
        let shared = Arc::new(RouteState {
            page: page.clone(),
            handler,
            token,
            port: bound.port(),
            reader_permits: Arc::new(Semaphore::new(MAX_READERS)),
            pixel_response_permits: Arc::new(Semaphore::new(MAX_PIXEL_RESPONSES)),
            end: receiver,
        });
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build()?;
        let serve = move || {
            runtime.block_on(serve(listener, shared));
            runtime.shutdown_background();
        };
        let thread = std::thread::Builder::new().name("live page".to_owned()).spawn(serve)?;
        Ok(Self { url, page, end, thread: Some(thread) })
    }

    /// Returns the URL of the page, which contains the secret token.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Ends the server. If a browser follows the page, the browser first has half a second to fetch
    /// the last picture.
    pub fn finish(self) {
        if self.page.reader_count() > 0 {
            std::thread::sleep(FINAL_FETCH_DELAY);
        }
    }
}

impl Drop for PageServer {
    fn drop(&mut self) {
        self.end.send_replace(true);
        if let Some(thread) = self.thread.take() {
            // If the server panicked, the render must go on.
            let _ = thread.join();
        }
    }
}

/// Returns an address at which this machine reaches a server that listens at `ip`. If `ip` is
/// unspecified (0.0.0.0 or ::, all addresses), the result is the loopback address, else `ip`.
fn reachable_address(ip: IpAddr) -> IpAddr {
    match ip {
        IpAddr::V4(Ipv4Addr::UNSPECIFIED) => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(Ipv6Addr::UNSPECIFIED) => Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    }
}

/// Serves HTTP requests until the server ends.
async fn serve(listener: TcpListener, shared: Arc<RouteState>) {
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
    let end = shared.end.clone();
    let router = Router::new()
        .route("/{token}/", get(send_page))
        .route("/{token}/events", get(send_events))
        .route("/{token}/layer/{name}", get(send_layer))
        .route("/{token}/source", get(send_source))
        .route("/{token}/save/{file}", get(send_saved_picture))
        .route("/{token}/request/{name}", post(handle_page_request))
        .layer(DefaultBodyLimit::max(MAX_BODY_BYTES))
        .layer(from_fn_with_state(shared.clone(), guard_request))
        .with_state(shared);
    let served = axum::serve(listener, router).with_graceful_shutdown(until_end(end.clone()));
    let connection_timeout = async {
        until_end(end).await;
        tokio::time::sleep(CONNECTION_CUT_DELAY).await;
    };
    tokio::select! {
        _ = served => {}
        () = connection_timeout => {}
    }
}

/// Waits until the server ends: until the value of `end` is true, or its sender is dropped.
async fn until_end(mut end: watch::Receiver<bool>) {
    // An error means that the sender was dropped with the server.
    let _ = end.wait_for(|end| *end).await;
}

/// Middleware that refuses requests which do not come from the page ([`check_request`]), and adds
/// security headers to all responses.
async fn guard_request(State(shared): State<Arc<RouteState>>, request: HttpRequest, next: Next) -> Response {
    let checked = check_request(request.uri().path(), request.headers(), &shared.token, shared.port);
    let mut response = match checked {
        Ok(()) => next.run(request).await,
        Err(refusal) => (StatusCode::FORBIDDEN, refusal.text()).into_response(),
    };
    let headers = response.headers_mut();
    headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert("cross-origin-resource-policy", HeaderValue::from_static("same-origin"));
    response
}

async fn send_page() -> Response {
    let Ok(nonce) = random_token() else { return StatusCode::INTERNAL_SERVER_ERROR.into_response() };
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; connect-src 'self'; \
         img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    let mut response = Html(page_html(&nonce)).into_response();
    if let Ok(policy) = HeaderValue::from_str(&policy) {
        response.headers_mut().insert(CONTENT_SECURITY_POLICY, policy);
    }
    response
}

async fn send_events(State(shared): State<Arc<RouteState>>) -> Response {
    match shared.reader_permits.clone().try_acquire_owned() {
        Ok(permit) => state_events_response(&shared.page, until_end(shared.end.clone()), permit),
        Err(_) => busy_response(),
    }
}

async fn send_layer(
    State(shared): State<Arc<RouteState>>,
    Path((_, name)): Path<(String, String)>,
    Query(known): Query<KnownFrameQuery>,
) -> Response {
    match shared.pixel_response_permits.clone().try_acquire_owned() {
        Ok(permit) => layer_pixels_response(shared.page.clone(), name, known, permit).await,
        Err(_) => busy_response(),
    }
}

async fn send_source(State(shared): State<Arc<RouteState>>) -> Response {
    scene_source_response(&shared.page)
}

async fn send_saved_picture(
    State(shared): State<Arc<RouteState>>,
    Path((_, file)): Path<(String, String)>,
    Query(options): Query<SaveOptions>,
) -> Response {
    match shared.pixel_response_permits.clone().try_acquire_owned() {
        Ok(permit) => saved_picture_response(shared.page.clone(), file, options, permit).await,
        Err(_) => busy_response(),
    }
}

async fn handle_page_request(
    State(shared): State<Arc<RouteState>>,
    Path((_, name)): Path<(String, String)>,
    body: Bytes,
) -> Response {
    match Request::parse(&name, &body) {
        Some(request) if (shared.handler)(request) => StatusCode::NO_CONTENT.into_response(),
        Some(_) => (StatusCode::CONFLICT, "the render cannot do this now\n").into_response(),
        None => (StatusCode::BAD_REQUEST, "unknown request\n").into_response(),
    }
}
