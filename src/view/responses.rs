//! HTTP responses of the live page: HTML page, events, pixels, scene text and saved pictures.

use super::frame::{FrameKind, LayerKind, LiveFrame};
use super::live_page::{LivePage, PublishedState};
use crate::image::{self, BitDepth, ExrPrecision, Image, OutputFormat, ToneMap, WriteOptions};
use axum::body::{Body, Bytes};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE, RETRY_AFTER};
use axum::http::{HeaderValue, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use std::convert::Infallible;
use std::future::Future;
use std::path::Path;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use tokio::sync::OwnedSemaphorePermit;
use tokio_stream::Stream;
use tokio_stream::wrappers::WatchStream;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
/// Scripts of the live page in the order of inclusion: each script uses only itself and earlier
/// ones.
const SCRIPTS: [&str; 8] = [
    include_str!("page/text.js"),
    include_str!("page/pixels.js"),
    include_str!("page/viewer.js"),
    include_str!("page/curve.js"),
    include_str!("page/panels.js"),
    include_str!("page/source.js"),
    include_str!("page/orbit.js"),
    include_str!("page/main.js"),
];

/// Returns the HTML page with its style and scripts. Their tags carry the text `nonce`; a browser
/// refuses style and scripts without it.
pub(super) fn page_html(nonce: &str) -> String {
    let script = format!("(() => {{\n\"use strict\";\n{}\n}})();", SCRIPTS.join("\n"));
    PAGE.replace("{nonce}", nonce).replace("{style}", STYLE).replace("{script}", &script)
}

/// Stream of server-sent events for one browser. Each event is the newest state of the render as
/// JSON. The stream ends when the server ends.
struct StateEvents {
    states: WatchStream<Arc<PublishedState>>,
    end: Pin<Box<dyn Future<Output = ()> + Send>>,
    _permit: OwnedSemaphorePermit,
}

impl Stream for StateEvents {
    type Item = Result<Event, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        // Send the last state before the stream ends.
        match Pin::new(&mut self.states).poll_next(context) {
            Poll::Ready(Some(state)) => return Poll::Ready(Some(Ok(Event::default().data(state.json())))),
            Poll::Ready(None) => return Poll::Ready(None),
            Poll::Pending => {}
        }
        self.end.as_mut().poll(context).map(|()| None)
    }
}

/// Returns the response that streams each new state of the render to a browser. The stream ends
/// when the future `end` resolves.
///
/// A state is sent only when the connection accepts it. A slow browser misses states, so states do
/// not pile up. `permit` limits the number of such streams, and is held until the stream ends.
pub(super) fn state_events_response(
    page: &LivePage,
    end: impl Future<Output = ()> + Send + 'static,
    permit: OwnedSemaphorePermit,
) -> Response {
    let states = WatchStream::new(page.subscribe());
    Sse::new(StateEvents { states, end: Box::pin(end), _permit: permit })
        .keep_alive(KeepAlive::default())
        .into_response()
}

/// Returns a response that tells the browser to ask again later, because there are too many
/// requests.
pub(super) fn busy_response() -> Response {
    let mut response = (StatusCode::SERVICE_UNAVAILABLE, "too many requests at a time\n").into_response();
    response.headers_mut().insert(RETRY_AFTER, HeaderValue::from_static("1"));
    response
}

/// Encoded pixels or picture file that is being sent to a browser. The permit limits the number of
/// simultaneous responses with pixels. The permit is released when all bytes are sent.
struct BytesInProgress {
    bytes: Bytes,
    _permit: OwnedSemaphorePermit,
}

/// Returns the body of a response that sends `bytes`. `permit`, which limits the number of
/// simultaneous responses, is held until all bytes are sent.
fn limited_body(bytes: Bytes, permit: OwnedSemaphorePermit) -> Body {
    Body::from(Bytes::from_owner(BytesInProgress { bytes, _permit: permit }))
}

impl AsRef<[u8]> for BytesInProgress {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Query of a request for pixels, which tells the frame that the browser already shows.
#[derive(Debug, Default, Deserialize)]
pub(super) struct KnownFrameQuery {
    /// Sequence number of the frame that the browser shows; 0 if it shows none.
    #[serde(default)]
    after: u32,
}

/// Returns the response with the encoded pixels of the newest layer `name`. The name `reference`
/// stands for the reference picture, which is sent at every request.
///
/// The response has no content if the browser already shows the newest frame, or if that frame
/// lacks the layer. The status is 404 if no kind of layer has this name.
///
/// A request for an error map also asks the render to make new maps. A request for a surface AOV
/// asks the render for surface AOVs if there are none.
pub(super) async fn layer_pixels_response(
    page: Arc<LivePage>,
    name: String,
    known: KnownFrameQuery,
    permit: OwnedSemaphorePermit,
) -> Response {
    let encode = move || {
        if name == "reference" {
            return page.reference()?.encoded_layer(LayerKind::Picture);
        }
        let kind = LayerKind::from_url_name(&name)?;
        let newest = page.newest_state();
        let frame = match kind.frame_kind() {
            FrameKind::Picture => &newest.state.picture,
            FrameKind::ErrorMaps => {
                page.request_error_maps();
                &newest.state.error_maps
            }
            FrameKind::SurfaceAovs => {
                if newest.state.surface_aovs.is_none() {
                    page.request_surface_aovs();
                }
                &newest.state.surface_aovs
            }
        };
        let newer = frame.as_ref().filter(|frame| frame.sequence > known.after);
        // An empty answer is no error: a later frame may have this layer.
        Some(newer.and_then(|frame| frame.encoded_layer(kind)).unwrap_or_default())
    };
    match tokio::task::spawn_blocking(encode).await {
        Ok(Some(bytes)) if bytes.is_empty() => StatusCode::NO_CONTENT.into_response(),
        Ok(Some(bytes)) => ([(CONTENT_TYPE, "application/octet-stream")], limited_body(bytes, permit)).into_response(),
        Ok(None) => (StatusCode::NOT_FOUND, "there is no such layer\n").into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

/// Returns the response with the text of the scene file and its errors, as JSON.
pub(super) fn scene_source_response(page: &LivePage) -> Response {
    let source = page.newest_state().state.source.clone();
    match serde_json::to_string(&*source) {
        Ok(json) => ([(CONTENT_TYPE, "application/json")], json).into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

/// Query of a request to save the picture: exposure and tone curve of a PNG file.
#[derive(Debug, Default, Deserialize)]
pub(super) struct SaveOptions {
    /// Exposure \[stops].
    #[serde(default)]
    exposure: f32,
    /// Name of the tone curve, as in `--tone`; `None` for sRGB.
    tone: Option<String>,
}

/// Returns the response with the newest picture as a file to save. The status is 404 if no pass is
/// finished. `file` ends with `.png` or `.exr`, which selects the format. `permit` limits the
/// number of responses with pixels, and is held until all bytes are sent.
pub(super) async fn saved_picture_response(
    page: Arc<LivePage>,
    file: String,
    options: SaveOptions,
    permit: OwnedSemaphorePermit,
) -> Response {
    let newest = page.newest_state();
    let Some(frame) = newest.state.picture.clone().filter(|frame| !frame.is_preview) else {
        return (StatusCode::NOT_FOUND, "there is no pass yet\n").into_response();
    };
    let (Ok(format), Ok(curve)) =
        (OutputFormat::from_path(Path::new(&file)), options.tone.as_deref().unwrap_or("srgb").parse())
    else {
        return (StatusCode::BAD_REQUEST, "choose .png or .exr, and tone srgb, filmic or course\n").into_response();
    };
    let tone = ToneMap { curve, exposure_stops: options.exposure };
    let kind = match format {
        OutputFormat::Png => "image/png",
        OutputFormat::Exr => "image/x-exr",
    };
    let name = format!("attachment; filename=\"{}\"", saved_file_name(&newest.state.status.scene, &frame, format));
    match tokio::task::spawn_blocking(move || encoded_picture(&frame, format, tone)).await {
        Ok(Some(bytes)) => {
            let mut response = ([(CONTENT_TYPE, kind)], limited_body(Bytes::from(bytes), permit)).into_response();
            if let Ok(name) = HeaderValue::from_str(&name) {
                response.headers_mut().insert(CONTENT_DISPOSITION, name);
            }
            response
        }
        Ok(None) => (StatusCode::BAD_REQUEST, "the picture cannot be encoded with this exposure\n").into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

/// Returns the name of a saved file, made from the name of the scene, the number of passes, and the
/// extension of the format.
fn saved_file_name(scene: &str, frame: &LiveFrame, format: OutputFormat) -> String {
    let stem = Path::new(scene).file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let stem: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    let extension = match format {
        OutputFormat::Png => "png",
        OutputFormat::Exr => "exr",
    };
    format!("{stem}-{}.{extension}", frame.passes)
}

/// Returns the picture of `frame` as the bytes of a file; `None` if encoding fails, for example
/// because the exposure is invalid.
fn encoded_picture(frame: &LiveFrame, format: OutputFormat, tone: ToneMap) -> Option<Vec<u8>> {
    let pixels = frame.layer(LayerKind::Picture)?.colors();
    let image = Image::from_pixels(frame.size.0, frame.size.1, pixels).ok()?;
    let software = ("Software".to_owned(), format!("Caustica {}", env!("CARGO_PKG_VERSION")));
    let options = WriteOptions {
        tone,
        bit_depth: BitDepth::Eight,
        exr_precision: ExrPrecision::Single,
        metadata: vec![software],
    };
    image::encode(format, &image, &options).ok().map(|(bytes, _)| bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use tokio::sync::Semaphore;

    #[test]
    fn saved_pictures_keep_permits_until_sent() {
        let page = Arc::new(LivePage::new("scene.txt".to_owned(), "path", false, None));
        page.publish(page.begin_render(), |state, sequence| {
            let frame = LiveFrame::from_picture(sequence, (2, 1), 7, &[Vec3::ONE; 2]);
            state.picture = Some(Arc::new(frame));
        });
        let permits = Arc::new(Semaphore::new(1));
        let permit = permits.clone().try_acquire_owned().unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let answer = saved_picture_response(page, "a.png".to_owned(), SaveOptions::default(), permit);
        let response = runtime.block_on(answer);
        assert_eq!((response.status(), permits.available_permits()), (StatusCode::OK, 0));
        drop(response);
        assert_eq!(permits.available_permits(), 1);
    }
}
