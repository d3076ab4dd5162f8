//! Volume photons: photons stored at scattering points in participating media.

use super::packet::{LANES, LineQuery, PointPacket, indices_of_set_bits};
use super::surface_photon::{PackedFlux, decode_octahedral, encode_octahedral};
use crate::accel::BoxTree;
use crate::color::Rgb;
use crate::math::{Bounds, Ray, morton_order};
use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_1_PI;

/// A photon stored at a scattering point in a medium, in 32 bytes.
///
/// The stored direction is precise to 10⁻⁴ rad. The error of each flux channel is at most 1.5·10⁻⁵
/// times the sum of the three channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumePhoton {
    /// Position of the scattering point.
    pub position: Vec3,
    /// Index of the medium in [`Scene::media`](crate::scene::Scene::media).
    pub medium: u32,
    flux: PackedFlux,
    /// Direction in which the photon travels before it scatters, in octahedral coordinates.
    direction: [u16; 2],
    /// Wavelength of the photon as [`Wavelength::byte_code`](crate::color::Wavelength::byte_code);
    /// 0 if it carries all wavelengths.
    pub wavelength_code: u8,
}

impl VolumePhoton {
    /// Packs a photon that scatters `flux` \[W] at `position`.
    ///
    /// `direction` is the unit direction of travel before scattering. Returns `None` if the
    /// position is not finite, if the flux is zero or not finite, or if a channel is negative.
    #[inline]
    #[must_use]
    pub fn new(position: Vec3, flux: Rgb, direction: Vec3, medium: u32, wavelength_code: u8) -> Option<Self> {
        let flux = PackedFlux::new(flux).filter(|_| position.is_finite())?;
        Some(Self { position, medium, flux, direction: encode_octahedral(direction), wavelength_code })
    }

    /// Flux of the photon \[W]. All of this flux scatters at the point.
    #[inline]
    #[must_use]
    pub fn flux(&self) -> Rgb {
        self.flux.flux()
    }

    /// Unit direction in which the photon travels before it scatters.
    #[inline]
    #[must_use]
    pub fn direction(&self) -> Vec3 {
        decode_octahedral(self.direction)
    }
}

/// Photons at scattering points in media, in a bounding volume hierarchy, for density estimates
/// with a kernel of fixed radius.
pub struct VolumePhotonMap {
    /// Photons of the map in Morton order.
    photons: Vec<VolumePhoton>,
    /// Positions of the photons, eight in a packet.
    packets: Vec<PointPacket>,
    /// Hierarchy over the bounding boxes of the packets. Each box is expanded by the kernel radius.
    boxes: BoxTree,
    radius: f32,
}

impl VolumePhotonMap {
    /// Builds the map for density estimates with kernels of radius `radius` \[length].
    ///
    /// The result does not depend on the number of threads.
    #[must_use]
    pub fn build(photons: Vec<VolumePhoton>, radius: f32) -> Self {
        let order = morton_order(&photons, |p| p.position);
        let photons: Vec<VolumePhoton> = order.par_iter().map(|i| photons[*i as usize]).collect();
        let radius = radius.max(0.0);
        let packet_and_bounds = |photons: &[VolumePhoton]| {
            let positions = || photons.iter().map(|p| p.position);
            (PointPacket::new(positions()), Bounds::from_points(positions()).expanded(radius))
        };
        let (packets, bounds): (Vec<PointPacket>, Vec<Bounds>) =
            photons.par_chunks(LANES).map(packet_and_bounds).unzip();
        Self { boxes: BoxTree::build(&bounds), photons, packets, radius }
    }

    /// Number of photons in the map.
    #[must_use]
    pub fn len(&self) -> usize {
        self.photons.len()
    }

    /// True if the map holds no photon.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// Radius of the kernels of density estimates \[length].
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Calls `visitor` for each photon within the kernel radius of `ray`, whose direction must be a
    /// unit vector.
    ///
    /// `visitor` receives the photon and four numbers: the distance t along the ray, the cosine
    /// between the directions of ray and photon, the 2D kernel K₂ \[1/length²], and d²/r². Here, d
    /// is the photon's distance from the ray, and r the kernel radius. The radiance that arrives at
    /// the ray's origin is Σ flux · p(−cos) · T(t) · K₂, with transmittance T. The phase function p
    /// takes the cosine between the directions of travel before and after scattering. This is the
    /// beam radiance estimate (Jarosz, Zwicker and Jensen 2008, section 5).
    #[inline]
    pub fn visit_near_ray(&self, ray: &Ray, mut visitor: impl FnMut(&VolumePhoton, f32, f32, f32, f32)) {
        let query = LineQuery::new(ray, self.radius);
        let r2 = f64::from(self.radius) * f64::from(self.radius);
        let scale = 3.0 * FRAC_1_PI / r2;
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let per_d2 = 1.0 / d.length_squared();
        self.boxes.visit_boxes_along_ray(ray, &mut |run| {
            for slot in indices_of_set_bits(self.packets[run as usize].points_near_line(&query)) {
                let photon = &self.photons[run as usize * LANES + slot];
                let to = photon.position.as_dvec3() - o;
                let t = to.dot(d) * per_d2;
                let d2 = (to - d * t).length_squared();
                if d2 < r2 && t > 0.0 && t < f64::from(ray.t_max) {
                    let (x2, cos) = (d2 / r2, ray.direction.dot(photon.direction()));
                    visitor(photon, t as f32, cos, (scale * (1.0 - x2) * (1.0 - x2)) as f32, x2 as f32);
                }
            }
        });
    }

    /// Calls `visitor` for each photon within the kernel radius of the point `p`.
    ///
    /// `visitor` receives the photon, the 3D kernel K₃ \[1/length³], and d²/r². Here, d is the
    /// photon's distance from `p`, and r the kernel radius. The in-scattered radiance per length is
    /// Σ flux · p(cos θ) · K₃, with phase function p and the angle θ between the directions of
    /// travel before and after scattering (Jensen and Christensen 1998, section 3.2).
    #[inline]
    pub fn visit_near_point(&self, p: Vec3, mut visitor: impl FnMut(&VolumePhoton, f32, f32)) {
        let inverse_radius = 1.0 / self.radius;
        let scale = (15.0 / 8.0 * FRAC_1_PI) as f32 * inverse_radius * inverse_radius * inverse_radius;
        let here = Ray { origin: p, direction: Vec3::Z, t_max: 0.0 };
        self.boxes.visit_boxes_along_ray(&here, &mut |run| {
            let (mask, x2) = self.packets[run as usize].points_within_radius(p, inverse_radius);
            for slot in indices_of_set_bits(mask) {
                let x2 = x2.as_array()[slot];
                visitor(&self.photons[run as usize * LANES + slot], scale * (1.0 - x2), x2);
            }
        });
    }
}

#[cfg(test)]
mod tests;
