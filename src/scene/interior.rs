//! What a walk remembers of the bodies that it is inside of, or nothing where a scene has none.

use super::inside::Crossing;
use super::touching::{Face, Sides};
use super::{Body, Effects, InteriorStack, Scattering, Scene, SurfaceInteraction};
use crate::bsdf::Bsdf;
use crate::color::{Rgb, Wavelength};
use crate::math::Ray;
use crate::sampling::Key;
use glam::Vec3;

/// What walks have to remember.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InteriorKind {
    /// Nothing: [`NoInterior`].
    Nothing,
    /// The bodies that they are inside of: [`InteriorStack`].
    Bodies,
    /// And what these are filled with, and a wavelength: [`SpectralInterior`](super::SpectralInterior).
    Spectral,
}

/// What a boundary is for a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryEvent {
    /// A surface.
    Surface,
    /// Not there for light, but it ends a shadow ray: bodies overlap.
    Hidden,
    /// Not there at all.
    Clear,
}

/// A medium around a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filling {
    /// Its index.
    pub medium: u32,
    /// Whether it fills the scene, and not a body.
    pub everywhere: bool,
}

/// The memory of a walk: [`SpectralInterior`](super::SpectralInterior), [`InteriorStack`], or [`NoInterior`] where there is nothing to remember. Walks are compiled for
/// each, so that scenes without bodies pay for none, and scenes without media for no media.
pub trait Interior: Copy + std::fmt::Debug + Send + Sync {
    /// Whether walks may go through media, or have a wavelength.
    const IMMERSED: bool;

    /// At the start of a camera ray that sees `effects`.
    fn at_camera(scene: &Scene, ray: &Ray, effects: Effects) -> Self;

    /// At light `light`, of a photon that sees `effects`.
    fn at_light(scene: &Scene, light: usize, effects: Effects) -> Self;

    /// The medium around.
    #[inline]
    fn medium(&self, _: &Scene) -> Option<Filling> {
        None
    }

    /// The wavelength that the walk has chosen.
    #[inline]
    fn wavelength(&self) -> Option<Wavelength> {
        None
    }

    /// Optical depth of `distance` in here, of what bodies absorb.
    fn depth(&self, scene: &Scene, distance: f32) -> Rgb;

    /// Part of the light that is left after `distance` in here.
    #[inline]
    fn transmittance(&self, scene: &Scene, distance: f32) -> Rgb {
        left_after(self.depth(scene, distance))
    }

    /// Learns of the boundary that `surface` may be, before the way to it is reckoned.
    fn approach(&mut self, surface: &SurfaceInteraction<'_>);

    /// What `surface` is for light; gives it the BSDF of what it divides. `key` is that of the vertex.
    fn meet(&mut self, scene: &Scene, surface: &mut SurfaceInteraction<'_>, key: Key) -> BoundaryEvent;

    /// Goes through the boundary that `surface` may be in unit `direction`.
    fn cross(&mut self, surface: &SurfaceInteraction<'_>, direction: Vec3);

    /// What throughput is multiplied by at `surface` before anything is done there, for a wavelength that was chosen there.
    #[inline]
    fn arrive(&mut self, _: &SurfaceInteraction<'_>) -> Rgb {
        Rgb::ONE
    }

    /// What throughput is multiplied by on leaving `surface`, for a wavelength that was chosen there.
    #[inline]
    fn leave(&mut self, _: &SurfaceInteraction<'_>, _: bool) -> Rgb {
        Rgb::ONE
    }
}

/// exp(−depth).
#[inline]
pub(super) fn left_after(depth: Rgb) -> Rgb {
    if depth == Rgb::ZERO { Rgb::ONE } else { (-depth).map(libm::expf) }
}

/// Nothing is remembered: bodies absorb nothing and lie in air.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoInterior;

impl Interior for NoInterior {
    const IMMERSED: bool = false;

    fn at_camera(_: &Scene, _: &Ray, _: Effects) -> Self {
        Self
    }

    fn at_light(_: &Scene, _: usize, _: Effects) -> Self {
        Self
    }

    #[inline]
    fn depth(&self, _: &Scene, _: f32) -> Rgb {
        Rgb::ZERO
    }

    #[inline]
    fn approach(&mut self, _: &SurfaceInteraction<'_>) {}

    #[inline]
    fn meet(&mut self, _: &Scene, _: &mut SurfaceInteraction<'_>, _: Key) -> BoundaryEvent {
        BoundaryEvent::Surface
    }

    #[inline]
    fn cross(&mut self, _: &SurfaceInteraction<'_>, _: Vec3) {}
}

#[inline]
pub(super) fn boundary(surface: &SurfaceInteraction<'_>) -> Option<Body> {
    match surface.material.scattering {
        Scattering::Boundary(body) => Some(body),
        _ => None,
    }
}

#[inline]
pub(super) fn entering(surface: &SurfaceInteraction<'_>) -> bool {
    surface.wo.dot(surface.point.ng) >= 0.0
}

impl InteriorStack {
    /// What `surface`, the boundary of `body`, is for light, the body on its inner side, and what it divides from what is outside.
    #[inline]
    pub(super) fn divided(
        &self,
        scene: &Scene,
        surface: &mut SurfaceInteraction<'_>,
        body: Body,
    ) -> (BoundaryEvent, Body, Crossing) {
        surface.touching = scene.faces_at(surface);
        let inwards = entering(surface);
        if !surface.touching.is_none() {
            let Sides { near, far, clear, roughness } = self.sides(scene, surface, &body, inwards);
            surface.roughness = roughness;
            let (inner, outer) = if inwards { (far, near) } else { (near, far) };
            let real = inner.map(|(material, _)| material) != outer.map(|(material, _)| material);
            let crossing = Crossing { real, outside: outer.map(|(_, body)| body) };
            let inner = inner.map_or_else(|| Body::new(1.0), |(_, body)| body);
            return (if clear { BoundaryEvent::Clear } else { crossing.meeting() }, inner, crossing);
        }
        let crossing = self.crossing(surface.index, &body, inwards, &scene.materials);
        (if body.clear { BoundaryEvent::Clear } else { crossing.meeting() }, body, crossing)
    }
}

impl Interior for InteriorStack {
    const IMMERSED: bool = false;

    fn at_camera(scene: &Scene, ray: &Ray, _: Effects) -> Self {
        if scene.camera.has_eye() { scene.camera_inside } else { scene.inside_at(ray.origin) }
    }

    fn at_light(scene: &Scene, light: usize, _: Effects) -> Self {
        scene.light_inside[light]
    }

    #[inline]
    fn depth(&self, scene: &Scene, distance: f32) -> Rgb {
        match self.top(&scene.materials) {
            Some((_, body)) if body.absorption != Rgb::ZERO => body.absorption * distance,
            _ => Rgb::ZERO,
        }
    }

    #[inline]
    fn approach(&mut self, surface: &SurfaceInteraction<'_>) {
        if boundary(surface).is_some() && !entering(surface) && !self.holds(surface.index) {
            self.found_inside(surface.index);
        }
    }

    #[inline]
    fn meet(&mut self, scene: &Scene, surface: &mut SurfaceInteraction<'_>, _: Key) -> BoundaryEvent {
        let Some(body) = boundary(surface) else { return BoundaryEvent::Surface };
        let (meeting, body, crossing) = self.divided(scene, surface, body);
        if meeting != BoundaryEvent::Clear {
            surface.bsdf = Bsdf::dielectric(crossing.eta(&body, |body| body.index), surface.roughness);
        }
        meeting
    }

    #[inline]
    fn cross(&mut self, surface: &SurfaceInteraction<'_>, direction: Vec3) {
        if boundary(surface).is_none() {
            return;
        }
        if surface.touching.is_none() {
            self.cross_boundary(surface.index, direction, surface.point.ng);
        } else {
            let entering = direction.dot(surface.point.ng) < 0.0;
            *self = self.beyond(Face::of(surface, entering), &surface.touching);
        }
    }
}
