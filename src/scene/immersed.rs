//! The memory of walks that go through media, or choose a wavelength.

use super::interior::boundary;
use super::{Body, BoundaryEvent, Effect, Effects, Filling, Interior, InteriorStack, Scene, SurfaceInteraction};
use crate::bsdf::{Bsdf, Dielectric, Transport};
use crate::color::{Rgb, Wavelength};
use crate::math::Ray;
use crate::sampling::{Dimension, Key};
use glam::Vec3;

/// Reflectances between which light that is thrown back stays white. Those of all wavelengths are then within a third of one another: towards
/// total reflection they are not, nor where both sides have nearly the same index.
const FAINT: std::ops::Range<f32> = 0.004..0.2;

/// [`InteriorStack`], and a wavelength where the walk has one.
///
/// A walk chooses its wavelength at the first surface that bends wavelengths differently, and keeps it. What such a surface reflects
/// faintly stays white.
#[derive(Clone, Copy, Debug)]
pub struct SpectralInterior {
    inside: InteriorStack,
    wavelength: Option<Wavelength>,
    /// The surface that was met as it were for the d line, where the wavelength was chosen there.
    chosen_at: Option<Dielectric>,
    effects: Effects,
}

impl SpectralInterior {
    fn new(inside: InteriorStack, effects: Effects) -> Self {
        Self { inside, wavelength: None, chosen_at: None, effects }
    }
}

impl Interior for SpectralInterior {
    const IMMERSED: bool = true;

    fn at_camera(scene: &Scene, ray: &Ray, effects: Effects) -> Self {
        Self::new(InteriorStack::at_camera(scene, ray, effects), effects)
    }

    fn at_light(scene: &Scene, light: usize, effects: Effects) -> Self {
        Self::new(InteriorStack::at_light(scene, light, effects), effects)
    }

    #[inline]
    fn medium(&self, scene: &Scene) -> Option<Filling> {
        if !self.effects.has(Effect::Media) {
            return None;
        }
        let (medium, everywhere) = match self.inside.top(&scene.materials) {
            Some((_, body)) => (body.medium, false),
            None => (scene.filling, true),
        };
        medium.map(|medium| Filling { medium, everywhere })
    }

    #[inline]
    fn wavelength(&self) -> Option<Wavelength> {
        self.wavelength
    }

    #[inline]
    fn depth(&self, scene: &Scene, distance: f32) -> Rgb {
        self.inside.depth(scene, distance)
    }

    #[inline]
    fn approach(&mut self, surface: &SurfaceInteraction<'_>) {
        self.inside.approach(surface);
    }

    #[inline]
    fn meet(&mut self, scene: &Scene, surface: &mut SurfaceInteraction<'_>, key: Key) -> BoundaryEvent {
        let (Some(body), true) = (boundary(surface), self.effects.has(Effect::Dispersion) && !scene.glasses.is_empty())
        else {
            return self.inside.meet(scene, surface, key);
        };
        let (meeting, body, crossing) = self.inside.divided(scene, surface, body);
        if meeting == BoundaryEvent::Clear {
            return meeting;
        }
        let disperses = body.glass.is_some() || crossing.outside.is_some_and(|body| body.glass.is_some());
        if disperses && crossing.real && self.wavelength.is_none() {
            self.wavelength = Some(Wavelength::sample(key.uniform(Dimension::Wavelength)));
            self.chosen_at = Some(Dielectric { eta: crossing.eta(&body, |body| body.index) });
        }
        let index = |body: &Body| match (body.glass, self.wavelength) {
            (Some(glass), Some(wavelength)) => scene.glasses[glass as usize].index(wavelength.nanometres()),
            _ => body.index,
        };
        surface.bsdf = Bsdf::dielectric(crossing.eta(&body, index), surface.roughness);
        meeting
    }

    #[inline]
    fn cross(&mut self, surface: &SurfaceInteraction<'_>, direction: Vec3) {
        self.inside.cross(surface, direction);
    }

    #[inline]
    fn arrive(&mut self, surface: &SurfaceInteraction<'_>) -> Rgb {
        // Connections are made here too.
        if surface.bsdf.is_specular() || self.chosen_at.take().is_none() {
            return Rgb::ONE;
        }
        self.wavelength.map_or(Rgb::ONE, Wavelength::weight)
    }

    #[inline]
    fn leave(&mut self, surface: &SurfaceInteraction<'_>, transmitted: bool) -> Rgb {
        let (Some(plain), Some(wavelength)) = (self.chosen_at.take(), self.wavelength) else { return Rgb::ONE };
        let weight = wavelength.weight();
        if !transmitted && let Bsdf::Dielectric(own) = surface.bsdf {
            let reflected = |glass: Dielectric| {
                let point = &surface.point;
                glass.split(surface.wo, point.ns, point.ng, Transport::Importance).reflected.1
            };
            let (plain, own) = (reflected(plain), reflected(own));
            if FAINT.contains(&plain) && own > 0.0 {
                // The mean over wavelengths of R(λ)·w(λ), with R of the d line as a control variate for what is left white.
                self.wavelength = None;
                return (weight * (own - plain) + plain) / own;
            }
        }
        weight
    }
}
