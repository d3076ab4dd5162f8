//! What a walk remembers of the bodies that it is inside of, or nothing where a scene has none.

use super::{Body, Inside, Scattering, Scene, Surface};
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::math::Ray;
use glam::Vec3;

/// The memory of a walk: [`Inside`], or [`Open`] where there is nothing to remember. Walks are compiled for each, so that scenes
/// without bodies pay for none.
pub trait Interior: Copy + std::fmt::Debug + Send + Sync {
    /// At the start of a camera ray.
    fn at_camera(scene: &Scene, ray: &Ray) -> Self;

    /// At light `light`.
    fn at_light(scene: &Scene, light: usize) -> Self;

    /// Part of the light that is left after `distance` in here.
    fn transmittance(&self, scene: &Scene, distance: f32) -> Rgb;

    /// Learns of the boundary that `surface` may be, before the way to it is reckoned.
    fn approach(&mut self, surface: &Surface<'_>);

    /// Whether `surface` is there for light; gives it the BSDF of what it divides.
    fn meet(&self, scene: &Scene, surface: &mut Surface<'_>) -> bool;

    /// Goes through the boundary that `surface` may be in unit `direction`.
    fn cross(&mut self, surface: &Surface<'_>, direction: Vec3);
}

/// Nothing is remembered: bodies absorb nothing and lie in air.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Open;

impl Interior for Open {
    fn at_camera(_: &Scene, _: &Ray) -> Self {
        Self
    }

    fn at_light(_: &Scene, _: usize) -> Self {
        Self
    }

    #[inline]
    fn transmittance(&self, _: &Scene, _: f32) -> Rgb {
        Rgb::ONE
    }

    #[inline]
    fn approach(&mut self, _: &Surface<'_>) {}

    #[inline]
    fn meet(&self, _: &Scene, _: &mut Surface<'_>) -> bool {
        true
    }

    #[inline]
    fn cross(&mut self, _: &Surface<'_>, _: Vec3) {}
}

#[inline]
fn boundary(surface: &Surface<'_>) -> Option<Body> {
    match surface.material.scattering {
        Scattering::Boundary(body) => Some(body),
        _ => None,
    }
}

#[inline]
fn entering(surface: &Surface<'_>) -> bool {
    surface.wo.dot(surface.point.ng) >= 0.0
}

impl Interior for Inside {
    fn at_camera(scene: &Scene, ray: &Ray) -> Self {
        if scene.camera.has_eye() { scene.camera_inside } else { scene.inside_at(ray.origin) }
    }

    fn at_light(scene: &Scene, light: usize) -> Self {
        scene.light_inside[light]
    }

    #[inline]
    fn transmittance(&self, scene: &Scene, distance: f32) -> Rgb {
        match self.top(&scene.materials) {
            Some((_, body)) if body.absorption != Rgb::ZERO => (-body.absorption * distance).map(libm::expf),
            _ => Rgb::ONE,
        }
    }

    #[inline]
    fn approach(&mut self, surface: &Surface<'_>) {
        if boundary(surface).is_some() && !entering(surface) && !self.holds(surface.index) {
            self.found_inside(surface.index);
        }
    }

    #[inline]
    fn meet(&self, scene: &Scene, surface: &mut Surface<'_>) -> bool {
        let Some(body) = boundary(surface) else { return true };
        let crossing = self.crossing(surface.index, &body, entering(surface), &scene.materials);
        surface.bsdf = Bsdf::dielectric(crossing.eta, surface.roughness);
        crossing.real
    }

    #[inline]
    fn cross(&mut self, surface: &Surface<'_>, direction: Vec3) {
        if boundary(surface).is_some() {
            self.cross_boundary(surface.index, direction, surface.point.ng);
        }
    }
}
