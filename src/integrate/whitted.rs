//! Ray tracing (Whitted 1980): shading by shadow rays to the middle of each light, reflection and refraction in Fresnel's shares,
//! until a branch is too deep or too faint.

use super::direct::Asking;
use super::maps::Maps;
use super::method::{AtReceiver, History, Method, Vertex};
use super::prepared::{Strategy, Walks};
use crate::scene::Interior;

/// A branch fainter than one level of an 8-bit picture is cut.
const FAINTEST: f32 = 1.0 / 256.0;

/// Ray tracing.
#[derive(Debug)]
pub(super) struct Whitted;

impl Strategy for Whitted {
    fn samples(&self) -> u32 {
        1
    }

    fn asking(&self) -> Asking {
        Asking::Middles
    }

    fn walk(&self, walks: Walks<'_>, _: &Maps<'_>) {
        walks.by(&Shaded);
    }
}

struct Shaded;

impl Method for Shaded {
    fn at_receiver<I: Interior>(&self, _: &Vertex<'_, I>) -> AtReceiver {
        AtReceiver { direct: true, onward: false }
    }

    fn counts(&self, _: History) -> bool {
        true
    }

    fn cut(&self) -> f32 {
        FAINTEST
    }
}
