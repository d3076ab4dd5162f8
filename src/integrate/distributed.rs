//! Distributed ray tracing (Cook, Porter and Carpenter 1984): ray tracing whose lights have a size, whose reflections may be
//! glossy and whose pixels have an area, each sampled by chance. Matt surfaces do not light each other.

use super::direct::Asking;
use super::maps::Maps;
use super::method::{AtReceiver, History, Method, Vertex};
use super::prepared::{Strategy, Walks};
use crate::bsdf::Bsdf;
use crate::scene::Interior;

/// Distributed ray tracing.
#[derive(Debug)]
pub(super) struct Distributed;

impl Strategy for Distributed {
    fn samples(&self) -> u32 {
        4
    }

    fn asking(&self) -> Asking {
        Asking::Walk
    }

    fn walk(&self, walks: Walks<'_>, _: &Maps<'_>) {
        walks.by(&Glossy);
    }
}

struct Glossy;

impl Method for Glossy {
    /// A gloss is followed, a matt part is not.
    fn part(&self, bsdf: Bsdf, chance: f32) -> Bsdf {
        match bsdf {
            Bsdf::Phong(phong) => phong.part(chance),
            other => other,
        }
    }

    fn at_receiver<I: Interior>(&self, vertex: &Vertex<'_, I>) -> AtReceiver {
        AtReceiver { direct: true, onward: !matches!(vertex.surface.bsdf, Bsdf::Diffuse(_)) }
    }

    fn counts(&self, _: History) -> bool {
        true
    }
}
