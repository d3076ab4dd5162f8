//! Light tracing: connects caustic photons to the camera and splats their light on the film.
//!
//! The method is described by Veach 1997, section 10.3. [`PassDensityEstimateShares`] takes the
//! place of multiple importance sampling weights (Georgiev et al. 2012): each caustic photon
//! divides its flux between density estimates and its splat.

use super::PhotonKind;
use super::density_estimate_shares::PassDensityEstimateShares;
use super::deposits::{Deposit, DepositPlace, Splat};
use super::surface_photon::SHARE_STEPS;
use crate::bsdf::TransportMode;
use crate::camera::{Camera, CameraConnection, Filter};
use crate::color::Rgb;
use crate::math::Ray;
use crate::sampling::{Dimension, Key};
use crate::scene::{Interior, PathRay, Scene, SurfaceInteraction};
use glam::DVec3;
use rayon::prelude::*;

/// Connects caustic photons to the camera of a scene, and splats their light on the film.
#[derive(Clone, Copy, Debug)]
pub struct LightTracer<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    /// True if camera rays start at random points of the lens; false if at its center.
    samples_lens: bool,
    /// True if the scene has surfaces that a connection from a photon to the camera can pass
    /// through: null interfaces or thin sheets.
    connections_cross_surfaces: bool,
    /// Fraction of a photon's flux that density estimates use, for each pixel; splats get the rest.
    /// `None` gives the whole flux to both, for simulations that only count splats.
    shares: Option<PassDensityEstimateShares<'a>>,
}

impl<'a> LightTracer<'a> {
    /// Creates a light tracer for the camera of `scene`.
    ///
    /// `samples_lens` is true if camera rays start at random points of the lens, false if at its
    /// center. `shares` splits the flux of photons between density estimates and splats. With
    /// `None`, both get the whole flux.
    #[must_use]
    pub fn new(scene: &'a Scene, samples_lens: bool, shares: Option<PassDensityEstimateShares<'a>>) -> Self {
        let connections_cross_surfaces = scene.shadow_rays_cross_surfaces();
        Self { scene, camera: scene.camera(), samples_lens, connections_cross_surfaces, shares }
    }

    /// Connects a caustic photon at `surface` to the camera, and passes the splat to `deposit`.
    /// Returns the fraction of the photon's flux that density estimates use, in units of
    /// 1/[`SHARE_STEPS`].
    ///
    /// `flux` \[W] is the photon's whole flux. `path_ray` is the path's ray that hit `surface`.
    /// `key` gives the random numbers of the path vertex. The function adds its shadow ray to
    /// `rays`. There is no splat if the camera does not see the point, if the fraction is 1, or if
    /// `surface` stores no photons. The function is not inlined, which keeps passes without light
    /// tracing fast.
    #[inline(never)]
    pub(super) fn splat_and_return_share<I: Interior>(
        &self,
        surface: &SurfaceInteraction<'_>,
        flux: Rgb,
        path_ray: &PathRay<I>,
        key: Key,
        rays: &mut u64,
        deposit: &mut impl FnMut(Deposit<'_>),
    ) -> u8 {
        let p = surface.point.p;
        // The share is a function of the position on the surface, so it must not depend on the lens
        // sample.
        let Some(central) = self.camera.connect_to_point(p, None) else { return SHARE_STEPS };
        let share =
            self.shares.map_or(SHARE_STEPS, |shares| shares.share_steps_at_film_position(central.film_position));
        let splat_share = match self.shares {
            None => 1.0,
            Some(_) => 1.0 - f32::from(share) / f32::from(SHARE_STEPS),
        };
        // A mix may resolve to a material that casts caustics, such as glass. Camera paths find the
        // light that such a material sends to the camera.
        if splat_share == 0.0 || !surface.bsdf.stores_photons() {
            return share;
        }
        let connection = if self.samples_lens && self.camera.lens().is_some() {
            self.camera.connect_to_point(p, Some(key.uniform_2d(Dimension::Lens)))
        } else {
            Some(central)
        };
        if let Some(connection) = connection {
            let radiance = splat_share * flux * self.splat_per_flux(surface, &connection);
            if radiance != Rgb::ZERO {
                *rays += 1;
                let radiance = radiance * self.transmittance(surface, &connection, path_ray, key);
                let place = DepositPlace::Film(connection.film_position);
                deposit(Deposit { kind: PhotonKind::Caustic, place, flux: radiance, wavelength: None });
            }
        }
        share
    }

    /// Returns the factor \[pixel²/(m² sr)] from the flux of a photon at `surface` to its splat. A
    /// splat is measured as radiance times film area.
    ///
    /// The factor includes the BSDF and the cosine, but not media and occlusion. It is 0 if the
    /// camera is behind a surface that does not transmit.
    fn splat_per_flux(&self, surface: &SurfaceInteraction<'_>, connection: &CameraConnection) -> Rgb {
        let normal = surface.facing_normal();
        let cosine = connection.direction_to_camera.dot(normal);
        let transmits = surface.bsdf.transmits();
        if cosine <= 0.0 && !transmits {
            return Rgb::ZERO;
        }
        let ns = if surface.wo.dot(surface.point.ng) < 0.0 { -surface.point.ns } else { surface.point.ns };
        // `normal` tells on which side of a transmitting surface the camera is, as in density
        // estimates.
        let ng = if transmits { normal } else { ns };
        let bsdf = surface.bsdf.evaluate(connection.direction_to_camera, surface.wo, ns, ng, TransportMode::Radiance);
        bsdf * (cosine.abs() * connection.importance)
    }

    /// Returns the transmittance between `surface` and the camera; 0 if a surface blocks the
    /// connection.
    fn transmittance<I: Interior>(
        &self,
        surface: &SurfaceInteraction<'_>,
        connection: &CameraConnection,
        path_ray: &PathRay<I>,
        key: Key,
    ) -> Rgb {
        let ray = surface.spawn_ray_to(connection.ray_origin, connection.direction_to_camera);
        let is_occluded = self.scene.occluded(&ray);
        if is_occluded && !self.connections_cross_surfaces {
            return Rgb::ZERO;
        }
        let key = key.camera_connection_key();
        let mut leaving = *path_ray;
        let direction = connection.direction_to_camera;
        leaving.leave_surface_with_wavelength_weight(surface, direction, surface.is_transmitted(direction));
        if is_occluded {
            return self.scene.shadow_transmittance(&ray, leaving.interior, leaving.cone.effects, key);
        }
        let distance = (connection.ray_origin - surface.point.p).length();
        let unit = Ray { t_max: distance, ..Ray::new(surface.point.p, connection.direction_to_camera) };
        self.scene.interior_transmittance(&unit, &leaving.interior, key)
    }
}

/// Adds copies of the splats of a panorama near its seam and poles. A copy lies beyond the edge of
/// the film, at a film position that shows the same direction, if the pixel filter reaches the film
/// from there.
///
/// Pixels at the seam and at the poles also filter light from beyond the edge of the film. There,
/// density estimates add only a part of the caustic flux, so copied splats must add the rest.
pub fn add_splats_across_seams(splats: &mut Vec<Splat>, camera: &Camera, filter: &Filter) {
    // The centers of the outermost pixels lie half a pixel inside the film.
    let margin = filter.radius() - 0.5;
    let mut copies = Vec::new();
    for splat in &*splats {
        camera.for_each_other_film_position(splat.film_position, margin, |film_position| {
            copies.push(Splat { film_position, ..*splat });
        });
    }
    splats.append(&mut copies);
}

/// Filters `splats` with the pixel filter, and adds their radiance \[W/(m² sr)] to the pixels of
/// `image`, which are stored by rows from the top.
///
/// `width` is the number of pixels per row. The sums do not depend on the number of threads: each
/// row adds its splats in a fixed order.
pub fn add_splats(mut splats: Vec<Splat>, filter: &Filter, width: u32, image: &mut [Rgb]) {
    let row_of = |splat: &Splat| splat.film_position.y.floor() as i32;
    splats.par_sort_by_key(row_of);
    let radius = filter.radius();
    let reach = radius.ceil() as i32;
    let empty_row = || vec![DVec3::ZERO; width as usize];
    image.par_chunks_mut(width as usize).enumerate().for_each_init(empty_row, |sums, (y, pixels)| {
        let y = y as i32;
        let first = splats.partition_point(|splat| row_of(splat) < y - reach);
        let end = splats.partition_point(|splat| row_of(splat) <= y + reach);
        sums.fill(DVec3::ZERO);
        for splat in &splats[first..end] {
            // Pixel centers have the fractional part ½.
            let position = splat.film_position - 0.5;
            let weight = filter.normalized_axis_value(y as f32 - position.y);
            if weight == 0.0 {
                continue;
            }
            let radiance = splat.integrated_radiance.as_dvec3() * f64::from(weight);
            let left = (position.x - radius).ceil().max(0.0) as usize;
            let right = (position.x + radius + 1.0).clamp(0.0, width as f32) as usize;
            for (x, sum) in sums.iter_mut().enumerate().take(right).skip(left) {
                *sum += radiance * f64::from(filter.normalized_axis_value(x as f32 - position.x));
            }
        }
        pixels.iter_mut().zip(&*sums).for_each(|(pixel, sum)| *pixel += sum.as_vec3());
    });
}

#[cfg(test)]
mod tests;
