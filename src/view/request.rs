//! Requests of a browser to the render on the live page.

use serde::{Deserialize, Serialize};

/// Camera position on a sphere around a pivot, relative to the camera position in the scene file.
/// The pivot is the scene point in the center of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Orbit {
    /// Angle by which the camera moves to the right around the up vector \[radians].
    pub yaw: f64,
    /// Angle by which the viewing direction turns upwards \[radians]; the camera itself moves down.
    pub pitch: f64,
    /// Zoom: ln(d/d₀), where d is the camera's distance from the pivot and d₀ the distance in the
    /// scene file. Negative values move the camera closer.
    #[serde(rename = "zoom")]
    pub log_distance: f64,
}

/// Request of a browser to the render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// Stop after the current pass. `caustica view` pauses its render; `caustica render` ends.
    Stop,
    /// Continue a paused render of `caustica view`.
    Resume,
    /// Move the camera of `caustica view` to this position.
    Orbit(Orbit),
}

impl Request {
    /// Parses a request from its name and its body; `None` if the request is unknown or the body is
    /// invalid.
    pub(super) fn parse(name: &str, body: &[u8]) -> Option<Self> {
        match name {
            "stop" => Some(Self::Stop),
            "resume" => Some(Self::Resume),
            "orbit" => serde_json::from_slice(body).ok().map(Self::Orbit),
            _ => None,
        }
    }
}
