//! Client of the image viewer tev: sends it pictures with named channels over TCP.
//!
//! A packet begins with its length in bytes as a 32-bit number (the length field included), then
//! one byte for its kind. Numbers are little-endian, and texts end with a byte 0. Two kinds are
//! sent: one creates an image with named channels, and one sets a window of its pixels.

use super::publication_throttle::PublicationThrottle;
use crate::image::ExrLayer;
use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Port on which the viewer tev listens by default.
const TEV_PORT: u16 = 14158;

/// Type byte of tev's packet that creates an image.
const CREATE_IMAGE: u8 = 4;

/// Type byte of tev's packet that sets pixels of an image. The packet states an offset and a stride
/// for each channel.
const UPDATE_IMAGE: u8 = 6;

/// Largest number of pixel values (all channels) in a packet. The limit is exceeded if a single row
/// of pixels has more values, because a packet holds whole rows.
const MAX_VALUES: usize = 1 << 18;

/// Longest time to wait for a connection, or for a viewer that has stopped reading. At the end of
/// the render, it is also the longest time to wait until the last images are sent.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Address of the viewer tev: a host and a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TevAddress {
    host: String,
    port: u16,
}

/// Error: a text is not a valid address of the viewer tev.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no address: write HOST or HOST:PORT, such as 127.0.0.1:14158")]
pub struct TevAddressError(String);

impl FromStr for TevAddress {
    type Err = TevAddressError;

    /// Parses `HOST:PORT`, or `HOST` with tev's own port. An IPv6 address stands in brackets.
    fn from_str(text: &str) -> Result<Self, TevAddressError> {
        let is_bracketed = text.starts_with('[') && text.ends_with(']');
        let (host, port) = match text.rsplit_once(':').filter(|_| !is_bracketed) {
            Some((host, port)) => (host, port.parse().map_err(|_| TevAddressError(text.to_owned()))?),
            None => (text, TEV_PORT),
        };
        let host = host.trim_start_matches('[').trim_end_matches(']');
        if host.is_empty() {
            return Err(TevAddressError(text.to_owned()));
        }
        Ok(Self { host: host.to_owned(), port })
    }
}

impl std::fmt::Display for TevAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Brackets separate the colons of an IPv6 address from the port.
        if self.host.contains(':') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}

/// Image to send: its name, its width and height \[pixels], and its layers.
#[derive(Debug)]
struct OutgoingImage {
    name: String,
    size: (u32, u32),
    layers: Vec<ExrLayer>,
}

/// Queue of images to send to the viewer, at most one per name.
#[derive(Debug, Default)]
struct WaitingImages {
    images: Vec<OutgoingImage>,
    /// True after the render has queued its last image.
    is_closed: bool,
    /// True after the connection has failed. Further images are dropped.
    has_failed: bool,
}

/// State that the render thread shares with the thread that sends images to the viewer.
#[derive(Debug, Default)]
struct SenderState {
    waiting: Mutex<WaitingImages>,
    changed: Condvar,
}

impl SenderState {
    fn change_waiting(&self, change: impl FnOnce(&mut WaitingImages)) {
        change(&mut self.waiting.lock().unwrap_or_else(PoisonError::into_inner));
        self.changed.notify_one();
    }

    /// Waits for the next image to send, and removes it from the queue. Returns `None` after the
    /// last image.
    fn next_image(&self) -> Option<OutgoingImage> {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if !waiting.images.is_empty() {
                return Some(waiting.images.remove(0));
            }
            if waiting.is_closed {
                return None;
            }
            waiting = self.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Connection of a render to the viewer tev.
///
/// A separate thread connects and sends queued images. A new image replaces a queued image of the
/// same name. The render waits for the thread only in [`finish`](Self::finish).
#[derive(Debug)]
pub struct TevClient {
    shared: Arc<SenderState>,
    throttle: PublicationThrottle,
    /// Receiver whose channel closes when the sending thread ends. No messages are sent.
    ended: Receiver<()>,
}

impl TevClient {
    /// Starts a thread that connects to `address` and sends queued images. The thread calls
    /// `report` if an error ends the connection.
    #[must_use]
    pub fn start(address: TevAddress, report: impl FnOnce(io::Error) + Send + 'static) -> Self {
        let shared = Arc::new(SenderState::default());
        let (end_signal, ended) = channel();
        let client = Self { shared: shared.clone(), throttle: PublicationThrottle::default(), ended };
        thread::spawn(move || {
            if let Err(error) = send_images(&address, &shared) {
                shared.change_waiting(|waiting| (waiting.has_failed, waiting.images) = (true, Vec::new()));
                report(error);
            }
            drop(end_signal);
        });
        client
    }

    /// Queues the layers that `layers` returns, as image `name` of `size` (width, height) pixels.
    /// If the last image was queued too recently, does nothing and does not call `layers`.
    ///
    /// The pause between images is so long that calls of `layers` take at most 1 % of the time of
    /// the render.
    pub fn queue_image_if_due(&mut self, name: &str, size: (u32, u32), layers: impl FnOnce() -> Vec<ExrLayer>) {
        let start = Instant::now();
        if self.throttle.is_due(start) {
            self.queue_image(name, size, layers());
            self.throttle.record(start, Instant::now());
        }
    }

    /// Queues `layers` for sending, as image `name` of `size` (width, height) pixels. Replaces a
    /// queued image of that name. Does not wait.
    pub fn queue_image(&self, name: &str, size: (u32, u32), layers: Vec<ExrLayer>) {
        self.shared.change_waiting(|waiting| {
            if !waiting.has_failed {
                waiting.images.retain(|image| image.name != name);
                waiting.images.push(OutgoingImage { name: name.to_owned(), size, layers });
            }
        });
    }

    /// Waits until all images are sent, but at most five seconds. Returns false if some images are
    /// then not sent. Returns true if all images are sent, or if the connection has failed.
    #[must_use]
    pub fn finish(self) -> bool {
        self.shared.change_waiting(|waiting| waiting.is_closed = true);
        self.ended.recv_timeout(TIMEOUT) != Err(RecvTimeoutError::Timeout)
    }
}

/// Connects to `address` and sends each image that is queued in `shared`, until the last image is
/// sent.
fn send_images(address: &TevAddress, shared: &SenderState) -> io::Result<()> {
    let mut stream = connect(address)?;
    stream.set_write_timeout(Some(TIMEOUT))?;
    // Name, size and channels of each image that the viewer knows.
    let mut known: Vec<(String, (u32, u32), Vec<String>)> = Vec::new();
    while let Some(image) = shared.next_image() {
        let channels = channel_names(&image.layers);
        let description = (image.name.clone(), image.size, channels);
        if !known.contains(&description) {
            stream.write_all(&create_image_packet(&image.name, image.size, &description.2))?;
            known.retain(|(name, ..)| *name != image.name);
            known.push(description);
        }
        let (width, height) = image.size;
        let values: Vec<&[f32]> =
            image.layers.iter().flat_map(|layer| &layer.channels).map(|(_, values)| &values[..]).collect();
        let rows = (MAX_VALUES / (width as usize * values.len()).max(1)).max(1) as u32;
        for top in (0..height).step_by(rows as usize) {
            let bottom = (top + rows).min(height);
            let names = channel_names(&image.layers);
            stream.write_all(&update_image_packet(&image.name, width, top..bottom, &names, &values))?;
        }
    }
    stream.flush()
}

/// Connects to the host of `address`: tries all its IP addresses until one answers.
fn connect(address: &TevAddress) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
    for socket in (address.host.as_str(), address.port).to_socket_addrs()? {
        match TcpStream::connect_timeout(&socket, TIMEOUT) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Returns the names of the channels of all `layers`, such as `noise.R`, with the name of the layer
/// as prefix.
fn channel_names(layers: &[ExrLayer]) -> Vec<String> {
    let names = |layer: &ExrLayer| -> Vec<String> {
        layer.channels.iter().map(|(channel, _)| layer.full_channel_name(channel)).collect()
    };
    layers.iter().flat_map(names).collect()
}

/// Returns the packet that creates an image of `width` × `height` pixels, and makes the viewer show
/// it.
fn create_image_packet(name: &str, (width, height): (u32, u32), channels: &[String]) -> Vec<u8> {
    let mut packet = Packet::new(CREATE_IMAGE, true, name);
    packet.push_u32s(&[width, height, channels.len() as u32]);
    channels.iter().for_each(|channel| packet.push_text(channel));
    packet.finish()
}

/// Returns the packet that sets the pixels in the rows `rows` of an image of `width` columns.
///
/// `values` holds a slice for each channel in `channels`: the values of all pixels of the image, in
/// rows from the top.
fn update_image_packet(
    name: &str,
    width: u32,
    rows: std::ops::Range<u32>,
    channels: &[String],
    values: &[&[f32]],
) -> Vec<u8> {
    let mut packet = Packet::new(UPDATE_IMAGE, false, name);
    packet.push_u32s(&[channels.len() as u32]);
    channels.iter().for_each(|channel| packet.push_text(channel));
    packet.push_u32s(&[0, rows.start, width, rows.end - rows.start]);
    let pixels = u64::from(width) * u64::from(rows.end - rows.start);
    // The values are planar: write the offset of each channel, then a stride of 1 for each.
    (0..channels.len() as u64).for_each(|channel| packet.bytes.extend((channel * pixels).to_le_bytes()));
    (0..channels.len()).for_each(|_| packet.bytes.extend(1u64.to_le_bytes()));
    let window = rows.start as usize * width as usize..rows.end as usize * width as usize;
    let values = values.iter().flat_map(|values| &values[window.clone()]);
    values.for_each(|value| packet.bytes.extend(value.to_le_bytes()));
    packet.finish()
}

/// Packet of tev's protocol that is being assembled.
struct Packet {
    bytes: Vec<u8>,
}

impl Packet {
    /// Begins a packet of the type `kind` about image `name`. If `grabs_focus` is true, the viewer
    /// shows the image.
    fn new(kind: u8, grabs_focus: bool, name: &str) -> Self {
        let mut packet = Self { bytes: vec![0, 0, 0, 0, kind, u8::from(grabs_focus)] };
        packet.push_text(name);
        packet
    }

    /// Appends `text` without its zero bytes, then a zero byte.
    fn push_text(&mut self, text: &str) {
        self.bytes.extend(text.bytes().filter(|byte| *byte != 0));
        self.bytes.push(0);
    }

    /// Appends `numbers`, each as four bytes in little-endian order.
    fn push_u32s(&mut self, numbers: &[u32]) {
        numbers.iter().for_each(|number| self.bytes.extend(number.to_le_bytes()));
    }

    /// Returns the bytes of the packet. The first four bytes hold the length of the packet.
    fn finish(mut self) -> Vec<u8> {
        let length = self.bytes.len() as u32;
        self.bytes[..4].copy_from_slice(&length.to_le_bytes());
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_a_host_and_a_port() {
        let address = |text: &str| text.parse::<TevAddress>().map(|address| address.to_string()).ok();
        assert_eq!(address("localhost"), Some("localhost:14158".to_owned()));
        assert_eq!(address("10.0.0.7:99"), Some("10.0.0.7:99".to_owned()));
        assert_eq!(address("[::1]:99"), Some("[::1]:99".to_owned()));
        assert_eq!(address("[::1]"), Some("[::1]:14158".to_owned()));
        assert_eq!([address(""), address(":7"), address("host:x"), address("host:70000")], [None, None, None, None]);
    }

    #[test]
    fn packets_follow_the_tev_protocol() {
        let channels = ["R".to_owned(), "a.Z".to_owned()];
        let created = create_image_packet("ab", (2, 3), &channels);
        let expected = b"\x1b\0\0\0\x04\x01ab\0\x02\0\0\0\x03\0\0\0\x02\0\0\0R\0a.Z\0";
        assert_eq!(created[4..], expected[4..]);
        assert_eq!(created[..4], (created.len() as u32).to_le_bytes());
        let (red, depth) = ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [9.0; 6]);
        let updated = update_image_packet("ab", 2, 1..3, &channels, &[&red, &depth]);
        let mut expected = b"\0\0\0\0\x06\0ab\0\x02\0\0\0R\0a.Z\0".to_vec();
        for number in [0u32, 1, 2, 2] {
            expected.extend(number.to_le_bytes());
        }
        for number in [0u64, 4, 1, 1] {
            expected.extend(number.to_le_bytes());
        }
        for value in [2.0f32, 3.0, 4.0, 5.0, 9.0, 9.0, 9.0, 9.0] {
            expected.extend(value.to_le_bytes());
        }
        assert_eq!(updated[4..], expected[4..]);
        assert_eq!(updated[..4], (expected.len() as u32).to_le_bytes());
    }
}
