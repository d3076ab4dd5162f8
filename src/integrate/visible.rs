//! What the camera sees, found by a pilot.

use super::EyeSettings;
use super::direct::{Asking, DirectLight};
use super::eye::EyePass;
use super::method::{AtReceiver, History, Method, Vertex};
use super::tiles::Worker;
use crate::bsdf::Transport;
use crate::color::{self, Rgb};
use crate::math::Bounds;
use crate::photon::{VisiblePoint, VisiblePointMap};
use crate::plan::Effects;
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Interior, Scene};
use glam::Vec2;

/// Camera rays of the pilot, four a pixel within these.
const RAYS: (u32, u32) = (2000, 20_000);

/// The radius within which photons count, as part of the extent of what is seen, at most: what matters lies around that, however large
/// the rest of the scene is.
const WIDEST: f32 = 0.1;

/// Points that the camera sees directly or over casters, spread over the picture; photons count within `radius` \[length] of one, or less
/// where little is seen.
pub(super) fn visible(scene: &Scene, settings: &EyeSettings, effects: Effects, radius: f32) -> VisiblePointMap {
    let direct = &DirectLight::new(scene, Asking::Middles, effects);
    let walks = EyePass { scene, effects, settings, direct, method: &Seen, samples: 1, density: None, pass: 0 };
    let key = Key::new(settings.seed).purpose(Purpose::Visible);
    let (width, height) = scene.camera().size();
    let size = Vec2::new(width as f32, height as f32);
    let rays = width.saturating_mul(height).saturating_mul(4).clamp(RAYS.0, RAYS.1);
    let draws = (0..rays).map(|i| Sampler::new(key, i, rays));
    let points: Vec<(Vec2, Sampler)> = draws.map(|draw| (draw.get_2d(Dimension::Film) * size, draw)).collect();
    let (_, workers) = walks.at(&points);
    let seen: Vec<VisiblePoint> = workers.into_iter().flat_map(|worker| worker.visible).collect();
    let extent = Bounds::of(seen.iter().map(|point| point.position)).extent().length();
    let radius = if extent > 0.0 { radius.min(extent * WIDEST) } else { radius };
    VisiblePointMap::new(seen, radius)
}

/// Notes the first receivers and computes nothing.
struct Seen;

impl Method for Seen {
    fn at_receiver<I: Interior>(&self, _: &Vertex<'_, I>) -> AtReceiver {
        AtReceiver { direct: false, onward: false }
    }

    fn photons<I: Interior>(&self, vertex: &Vertex<'_, I>, worker: &mut Worker) -> Rgb {
        let surface = vertex.surface;
        let normal = surface.facing_normal();
        let brdf = surface.bsdf.evaluate(surface.wo, normal, normal, normal, Transport::Radiance);
        let weight = color::mean(vertex.throughput * brdf);
        worker.visible.push(VisiblePoint { position: surface.point.p, normal, weight });
        Rgb::ZERO
    }

    fn in_medium(&self, _: History) -> AtReceiver {
        AtReceiver { direct: false, onward: false }
    }

    fn counts(&self, _: History) -> bool {
        false
    }
}
