//! Next-event estimation in media: light that reaches a point of the medium straight from a light,
//! and scatters there along a camera path.

use super::{CENTER, NextEventEstimator, ShadowRayScheme, stratified_sample};
use crate::color::Rgb;
use crate::integrate::vertex::MediumPathSegment;
use crate::integrate::worker::PathWorker;
use crate::light::ShadowTarget;
use crate::math::Ray;
use crate::medium::DistanceSample;
use crate::plan::Effect;
use crate::sampling::{Dimension, Sampler};
use crate::scene::{Interior, MediumSegment};
use glam::{Vec2, Vec3};

/// Sampled scattering point on a segment of a camera path through a medium.
struct ScatterPoint {
    p: Vec3,
    /// Scattering coefficient σs times the transmittance to the start of the segment, divided by
    /// the pdf of the distance.
    weight: Rgb,
}

impl NextEventEstimator<'_> {
    /// Estimates the direct light that a medium scatters to the start of a segment \[W/(m² sr)].
    ///
    /// `distance_sample` holds the distance at which the path itself scatters. If the path
    /// `continues` from there, its next ray may hit a light too. The balance heuristic then weights
    /// the estimate against this second technique.
    pub fn estimate_direct_light_in_medium<I: Interior>(
        &self,
        path_segment: &MediumPathSegment<'_, I>,
        distance_sample: &DistanceSample,
        continues: bool,
        worker: &mut PathWorker,
    ) -> Rgb {
        let segment = path_segment.segment;
        let path_point = || {
            let t = distance_sample.scattered?;
            Some(ScatterPoint { p: segment.ray.at(t), weight: distance_sample.weight })
        };
        let mut sum = Rgb::ZERO;
        match (self.shadow_ray_scheme(path_segment.history), &self.light_sampler) {
            (ShadowRayScheme::All(rays), _) => {
                for (i, light) in self.lights.iter().enumerate() {
                    let rays = if !light.is_delta() && !self.centers { rays } else { 1 };
                    let sampler = path_segment.shadow_sampler.nth_shadow_ray_sampler(i);
                    for ray in 0..rays {
                        let sampler = sampler.subsample_sampler(ray, rays);
                        let pivot = light.emission_point().filter(|_| segment.medium.is_homogeneous());
                        let point = pivot
                            .map_or_else(path_point, |pivot| sample_scatter_point_near(path_segment, pivot, sampler));
                        if let Some(point) = point {
                            sum += self.shadow_ray_contribution_in_medium(
                                &point,
                                i,
                                path_segment,
                                sampler,
                                rays as f32,
                                continues,
                                worker,
                            );
                        }
                    }
                }
            }
            (ShadowRayScheme::Chosen(rays), Some(light_sampler)) => {
                let Some(point) = path_point() else { return Rgb::ZERO };
                let start = path_segment.shadow_sampler.get_1d(Dimension::Light);
                for i in 0..rays {
                    let u = stratified_sample(i, start, rays);
                    let Some((light, probability, _)) = light_sampler.sample(point.p, None, u) else { continue };
                    let sampler = path_segment.shadow_sampler.nth_shadow_ray_sampler(i as usize);
                    let rays = probability * rays as f32;
                    sum += self.shadow_ray_contribution_in_medium(
                        &point,
                        light,
                        path_segment,
                        sampler,
                        rays,
                        continues,
                        worker,
                    );
                }
            }
            (ShadowRayScheme::Chosen(_), None) => {}
        }
        sum
    }

    /// Returns the radiance that one shadow ray from `point` to the light with index `light` adds
    /// at the start of the segment \[W/(m² sr)].
    ///
    /// `rays` is the expected number of shadow rays to that light.
    #[expect(clippy::too_many_arguments, reason = "one call's inputs, all of different kinds")]
    fn shadow_ray_contribution_in_medium<I: Interior>(
        &self,
        point: &ScatterPoint,
        light: usize,
        path_segment: &MediumPathSegment<'_, I>,
        sampler: Sampler,
        rays: f32,
        continues: bool,
        worker: &mut PathWorker,
    ) -> Rgb {
        let segment = path_segment.segment;
        let u = if self.centers { CENTER } else { sampler.get_2d(Dimension::LightPosition) };
        let Some(sample) = self.sample_li(light, point.p, u) else { return Rgb::ZERO };
        // Light arrives along −`wi` and leaves along the reversed ray direction: the two signs
        // cancel.
        let phase = segment.medium.phase.evaluate(segment.ray.direction.dot(sample.wi));
        let mut scattered = point.weight * sample.weight * (phase / rays);
        if scattered == Rgb::ZERO {
            return Rgb::ZERO;
        }
        if let (true, Some(pdf), false) = (continues, sample.pdf, self.centers) {
            let light_pdf = rays * pdf;
            scattered *= light_pdf / (light_pdf + phase);
        }
        let (ray, t_max) = match sample.target {
            ShadowTarget::Point(target) => (
                Ray::between_points(point.p, self.shadow_ray_end(light, &sample, target, point.p)),
                (target - point.p).length(),
            ),
            ShadowTarget::Infinity => (Ray::new(point.p, sample.wi), f32::INFINITY),
        };
        if self.effects.has(Effect::Shadows) {
            worker.counters.shadow_rays += 1;
            if self.scene.occluded(&ray) {
                return if self.has_null_interfaces {
                    scattered * self.scene.shadow_transmittance(&ray, segment.interior, sampler.sample_key())
                } else {
                    Rgb::ZERO
                };
            }
        }
        let ray = Ray { t_max, ..Ray::new(point.p, sample.wi) };
        scattered * self.scene.interior_transmittance(&ray, &segment.interior, sampler.sample_key())
    }
}

/// Samples a scattering point on a segment in a homogeneous medium, for light that leaves the point
/// `pivot`.
///
/// Half of the samples follow the transmittance. The other half are equiangular: uniform in the
/// angle seen from `pivot` (Kulla and Fajardo 2012, "Importance Sampling Techniques for Path
/// Tracing in Participating Media").
fn sample_scatter_point_near<I: Interior>(
    path_segment: &MediumPathSegment<'_, I>,
    pivot: Vec3,
    sampler: Sampler,
) -> Option<ScatterPoint> {
    let MediumSegment { ray, medium, .. } = path_segment.segment;
    let mut rng = sampler.sample_key().shadow_ray_scatter_point_key().rng();
    let angles = EquiangularDistribution::new(ray, pivot);
    let Vec2 { x: which, y: u } = sampler.get_2d(Dimension::Medium);
    let t = if which < 0.5 {
        medium.distance_sample(ray, ray.t_max, path_segment.throughput, &mut rng).scattered?
    } else {
        angles.sample(u)
    };
    let pdf = 0.5 * (medium.distance_pdf(t, path_segment.throughput)? + angles.pdf(t));
    if !(t >= 0.0 && t <= ray.t_max && pdf > 0.0) {
        return None;
    }
    let transmittance = medium.transmittance(ray, t, &mut rng);
    Some(ScatterPoint { p: ray.at(t), weight: transmittance * medium.scattering / pdf })
}

/// Distribution of distances along a ray that is uniform in the angle, seen from a pivot point such
/// as a point light.
struct EquiangularDistribution {
    /// Distance along the ray from its origin to the position closest to the pivot \[length].
    closest: f32,
    /// Smallest distance between the ray's line and the pivot \[length].
    distance: f32,
    /// Angle from the closest position to the start of the ray, seen from the pivot \[rad].
    from: f32,
    /// Angle from the closest position to the end of the ray, seen from the pivot \[rad].
    to: f32,
}

impl EquiangularDistribution {
    fn new(ray: &Ray, pivot: Vec3) -> Self {
        let to = pivot - ray.origin;
        let closest = to.dot(ray.direction);
        // Any positive distance is unbiased. With a distance below rounding errors, all samples
        // would fall on the closest point.
        let distance = (to - ray.direction * closest).length().max(1e-5 * to.length()).max(f32::MIN_POSITIVE);
        let angle = |t: f32| libm::atanf((t - closest) / distance);
        Self { closest, distance, from: angle(0.0), to: angle(ray.t_max) }
    }

    /// Returns the distance along the ray for uniform `u` in \[0, 1) \[length].
    fn sample(&self, u: f32) -> f32 {
        self.closest + self.distance * libm::tanf(self.from + (self.to - self.from) * u)
    }

    /// Returns the pdf of distance `t` along the ray \[1/length].
    fn pdf(&self, t: f32) -> f32 {
        let x = (t - self.closest) / self.distance;
        let range = self.to - self.from;
        if range > 0.0 { 1.0 / (self.distance * (1.0 + x * x) * range) } else { 0.0 }
    }
}
