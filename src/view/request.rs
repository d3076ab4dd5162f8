//! Requests of the page to the render.

use serde::{Deserialize, Serialize};

/// Position of the camera relative to that of the scene file, on a sphere around the point that
/// the center of the picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Orbit {
    /// Angle of the camera to the right around the up vector \[radians].
    pub yaw: f64,
    /// Angle by which the view rises \[radians].
    pub pitch: f64,
    /// Logarithm of the factor by which the distance grows.
    pub zoom: f64,
}

/// Request of a page to the render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// End the render after the current pass.
    Stop,
    /// Continue a render that was stopped.
    Resume,
    /// Move the camera.
    Orbit(Orbit),
}

impl Request {
    /// Parses a request: its name, and the text of its body; `None` if it is unknown.
    pub(super) fn parse(name: &str, body: &[u8]) -> Option<Self> {
        match name {
            "stop" => Some(Self::Stop),
            "resume" => Some(Self::Resume),
            "orbit" => serde_json::from_slice(body).ok().map(Self::Orbit),
            _ => None,
        }
    }
}
