//! Volume photons: which of them a ray through a medium passes, and which lie about a place.

use super::record::{decode, encode};
use crate::accel::Boxes;
use crate::color::Rgb;
use crate::math::{Bounds, Ray, morton_order};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// A photon where it scattered in a medium: 32 bytes.
///
/// Flux is right to 2⁻²⁴ in power and 1.5·10⁻⁵ in hue, the direction to 10⁻⁴ rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumePhoton {
    /// Place.
    pub position: Vec3,
    /// Which medium it scattered in.
    pub medium: u32,
    sum: f32,
    red: u16,
    green: u16,
    direction: [u16; 2],
    /// The code of its wavelength, 0 where it carries all.
    pub wavelength: u8,
}

impl VolumePhoton {
    /// Packs a place, flux \[W], and the unit direction of travel.
    ///
    /// `None` where the place or the flux is not finite, or the flux is zero or negative: such photons carry nothing, or would
    /// poison an estimate.
    #[inline]
    #[must_use]
    pub fn new(position: Vec3, flux: Rgb, direction: Vec3, medium: u32, wavelength: u8) -> Option<Self> {
        let sum = flux.x + flux.y + flux.z;
        if !(sum > 0.0 && sum.is_finite() && flux.min_element() >= 0.0 && position.is_finite()) {
            return None;
        }
        let fraction = |c: f32| (c / sum * 65_535.0 + 0.5) as u16;
        let (red, green) = (fraction(flux.x), fraction(flux.y));
        Some(Self { position, medium, sum, red, green, direction: encode(direction), wavelength })
    }

    /// Flux \[W].
    #[inline]
    #[must_use]
    pub fn flux(&self) -> Rgb {
        let unit = self.sum * (1.0 / 65_535.0);
        let (red, green) = (f32::from(self.red), f32::from(self.green));
        Rgb::new(red, green, (65_535.0 - red - green).max(0.0)) * unit
    }

    /// Unit direction of travel.
    #[inline]
    #[must_use]
    pub fn direction(&self) -> Vec3 {
        decode(self.direction)
    }
}

/// Photons of a run along the curve that share a box.
const RUN: usize = 8;

/// Volume photons that a ray or a place can be asked for.
pub struct PointMap {
    photons: Vec<VolumePhoton>,
    boxes: Boxes,
    radius: f32,
}

impl PointMap {
    /// Indexes photons for a blur of the given radius. The result does not depend on the number of threads.
    #[must_use]
    pub fn build(photons: Vec<VolumePhoton>, radius: f32) -> Self {
        let order = morton_order(&photons, |p| p.position);
        let photons: Vec<VolumePhoton> = order.par_iter().map(|i| photons[*i as usize]).collect();
        let bounds = |run: &[VolumePhoton]| Bounds::of(run.iter().map(|p| p.position)).expanded(radius);
        let boxes: Vec<Bounds> = photons.par_chunks(RUN).map(bounds).collect();
        Self { boxes: Boxes::build(&boxes), photons, radius }
    }

    /// How many photons are stored.
    #[must_use]
    pub fn len(&self) -> usize {
        self.photons.len()
    }

    /// Whether no photon is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// The radius of the blur \[scene units].
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Visits every photon closer than the radius to the ray, of unit direction, and not before its start or beyond its end: with the
    /// distance along the ray, the cosine between the ray's direction and the photon's, and K₂ \[1/length²].
    ///
    /// The beam radiance estimate (Jarosz, Zwicker and Jensen 2008, section 5): radiance towards the ray's origin is
    /// Σ flux · p(cos) · T(t) · weight for photons stored at scatterings. Allocates nothing.
    #[inline]
    pub fn visit(&self, ray: &Ray, mut visitor: impl FnMut(&VolumePhoton, f32, f32, f32)) {
        let r2 = self.radius * self.radius;
        let scale = 3.0 * FRAC_1_PI / r2;
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        self.boxes.along(ray, &mut |run| {
            for photon in self.run(run) {
                let to = photon.position.as_dvec3() - o;
                let t = to.dot(d) / d.length_squared();
                let d2 = (to - d * t).length_squared() as f32;
                if d2 < r2 && t > 0.0 && t < f64::from(ray.t_max) {
                    let x = 1.0 - d2 / r2;
                    visitor(photon, t as f32, ray.direction.dot(photon.direction()), scale * x * x);
                }
            }
        });
    }

    /// Visits every photon closer than the radius to a place, with K₃ \[1/length³]: there, Σ flux · p(cos) · weight is the
    /// light that scatters towards a ray in each unit of its length (Jensen and Christensen 1998, section 3.2). Allocates nothing.
    #[inline]
    pub fn around(&self, p: Vec3, mut visitor: impl FnMut(&VolumePhoton, f32)) {
        let r2 = self.radius * self.radius;
        let scale = 15.0 / 8.0 * FRAC_1_PI / (r2 * self.radius);
        let here = Ray { origin: p, direction: Vec3::Z, t_max: 0.0 };
        self.boxes.along(&here, &mut |run| {
            for photon in self.run(run) {
                let d2 = photon.position.distance_squared(p);
                if d2 < r2 {
                    visitor(photon, scale * (1.0 - d2 / r2));
                }
            }
        });
    }

    fn run(&self, index: u32) -> &[VolumePhoton] {
        let start = index as usize * RUN;
        &self.photons[start..self.photons.len().min(start + RUN)]
    }
}
