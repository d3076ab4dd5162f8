//! The [`Interior`] of paths in media and of paths with a wavelength.

use super::{Body, BoundaryContext, BoundaryEvent, CurrentMedium, Interior, InteriorStack, resolve_interface};
use crate::bsdf::{Bsdf, Dielectric, TransportMode};
use crate::color::{Rgb, Wavelength};
use crate::math::Ray;
use crate::sampling::Dimension;
use crate::scene::{Effect, Effects, Scene, SurfaceInteraction};
use glam::Vec3;

/// Range of Fresnel reflectances at a dispersive surface. If the reflectance is in this range, a
/// reflected path keeps all wavelengths.
///
/// Here, the reflectance varies by less than a third over the wavelengths. Outside the range, it
/// may vary more: near total reflection, and where both refractive indices are nearly equal.
const UNDISPERSED_REFLECTANCES: std::ops::Range<f32> = 0.004..0.2;

/// An [`InteriorStack`] for paths that pass through media, carry a wavelength, or both.
///
/// A path samples its wavelength at the first dispersive surface, and usually keeps it. The
/// exception is a reflection where the reflectance is in a low range: the path then continues with
/// all wavelengths, and samples a new wavelength at its next dispersive surface.
#[derive(Clone, Copy, Debug)]
pub struct SpectralInterior {
    stack: InteriorStack,
    wavelength: Option<Wavelength>,
    /// Uniform number in \[0, 1) from which the path samples its first wavelength.
    ///
    /// `None` after its use, or if [`Interior::set_wavelength_sample`] was not called. The path
    /// then samples its wavelength with a number from the random key of the vertex.
    wavelength_sample: Option<f32>,
    /// BSDF of the surface at which the path sampled its wavelength, with the refractive index at
    /// the d line (587.56 nm). Its reflectance decides whether a reflected path continues with all
    /// wavelengths.
    ///
    /// `None` if no wavelength was sampled, or once the weight of the wavelength has been applied
    /// to the throughput.
    wavelength_sampling_dielectric: Option<Dielectric>,
    effects: Effects,
}

impl SpectralInterior {
    fn new(stack: InteriorStack, effects: Effects) -> Self {
        Self { stack, wavelength: None, wavelength_sample: None, wavelength_sampling_dielectric: None, effects }
    }
}

impl Interior for SpectralInterior {
    const HAS_MEDIA_OR_WAVELENGTH: bool = true;

    fn interior_at_camera(scene: &Scene, ray: &Ray, effects: Effects) -> Self {
        Self::new(InteriorStack::interior_at_camera(scene, ray, effects), effects)
    }

    fn interior_at_light(scene: &Scene, light: usize, ray: &Ray, effects: Effects) -> Self {
        Self::new(InteriorStack::interior_at_light(scene, light, ray, effects), effects)
    }

    #[inline]
    fn set_wavelength_sample(&mut self, scene: &Scene, sample: impl FnOnce() -> f32) {
        if self.effects.has(Effect::Dispersion) && !scene.dispersion_formulas.is_empty() {
            self.wavelength_sample = Some(sample());
        }
    }

    #[inline]
    fn current_medium(&self, scene: &Scene) -> Option<CurrentMedium> {
        if !self.effects.has(Effect::Media) {
            return None;
        }
        let (medium, ambient) = match self.stack.dominant_body(&scene.materials) {
            Some((_, body)) => (body.medium, false),
            None => (scene.ambient_medium, true),
        };
        medium.map(|medium| CurrentMedium { medium_index: medium, ambient })
    }

    #[inline]
    fn wavelength(&self) -> Option<Wavelength> {
        self.wavelength
    }

    #[inline]
    fn absorption_optical_depth(&self, scene: &Scene, distance: f32) -> Rgb {
        self.stack.absorption_optical_depth(scene, distance)
    }

    #[inline]
    fn infer_starting_body(&mut self, surface: &SurfaceInteraction<'_>) {
        self.stack.infer_starting_body(surface);
    }

    #[inline]
    fn resolve_boundary(
        &mut self,
        scene: &Scene,
        surface: &mut SurfaceInteraction<'_>,
        context: &BoundaryContext,
    ) -> BoundaryEvent {
        let (Some(body), true) = (
            surface.material.enclosed_body(),
            self.effects.has(Effect::Dispersion) && !scene.dispersion_formulas.is_empty(),
        ) else {
            return self.stack.resolve_boundary(scene, surface, context);
        };
        let (event, body, interface) = resolve_interface(&self.stack, scene, surface, *body, context);
        if event == BoundaryEvent::NullInterface {
            return event;
        }
        let disperses = body.dispersion_formula.is_some()
            || interface.outside.is_some_and(|body| body.dispersion_formula.is_some());
        if disperses && !interface.is_hidden && self.wavelength.is_none() {
            // `take` the number: a second wavelength of this path needs another random number.
            let u = self.wavelength_sample.take().unwrap_or_else(|| context.key.uniform_1d(Dimension::Wavelength));
            self.wavelength = Some(Wavelength::sample(u));
            self.wavelength_sampling_dielectric =
                Some(Dielectric { eta: interface.relative_eta(&body, |body| body.eta) });
        }
        let eta = |body: &Body| match (body.dispersion_formula, self.wavelength) {
            (Some(formula), Some(wavelength)) => {
                scene.dispersion_formulas[formula as usize].refractive_index(wavelength.nanometres())
            }
            _ => body.eta,
        };
        let scattering = surface.material.boundary_microfacet_scattering();
        surface.bsdf = Bsdf::dielectric(interface.relative_eta(&body, eta), surface.boundary_roughness, scattering);
        event
    }

    #[inline]
    fn cross_boundary(&mut self, surface: &SurfaceInteraction<'_>, direction: Vec3) {
        self.stack.cross_boundary(surface, direction);
    }

    #[inline]
    fn wavelength_weight_before_scattering(&mut self, surface: &SurfaceInteraction<'_>) -> Rgb {
        // At a surface that is not specular, next-event estimation needs the weight too, so this
        // function applies it.
        if surface.bsdf.is_specular() || self.wavelength_sampling_dielectric.take().is_none() {
            return Rgb::ONE;
        }
        self.wavelength.map_or(Rgb::ONE, Wavelength::weight)
    }

    #[inline]
    fn wavelength_weight_after_scattering(&mut self, surface: &SurfaceInteraction<'_>, transmitted: bool) -> Rgb {
        let (Some(d_line_dielectric), Some(wavelength)) = (self.wavelength_sampling_dielectric.take(), self.wavelength)
        else {
            return Rgb::ONE;
        };
        let weight = wavelength.weight();
        let (wo, ns, ng) = (surface.wo, surface.point.ns, surface.point.ng);
        if !transmitted && let Some(sampled) = surface.bsdf.reflect_and_refract(wo, ns, ng, TransportMode::Importance) {
            let at_d_line = d_line_dielectric.reflect_and_refract(wo, ns, ng, TransportMode::Importance);
            let (d_line_reflectance, reflectance) = (at_d_line.reflected.1, sampled.reflected.1);
            if UNDISPERSED_REFLECTANCES.contains(&d_line_reflectance) && reflectance > 0.0 {
                // The path was reflected with probability R, the `reflectance` at the sampled
                // wavelength. The mean of the weight over all wavelengths is white (1). So the
                // reflectance R_d at the d line is a control variate: only R − R_d needs the
                // weight, and the part R_d is exact.
                self.wavelength = None;
                return (weight * (reflectance - d_line_reflectance) + d_line_reflectance) / reflectance;
            }
        }
        weight
    }
}
