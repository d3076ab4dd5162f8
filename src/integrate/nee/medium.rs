//! Next-event estimation in media: light that goes straight from a light to a point of the medium,
//! and scatters there along a camera path.

use super::{CENTER, NextEventEstimator, ScatterPointSampling, ShadowRayScheme, stratified_sample};
use crate::color::{self, Rgb};
use crate::integrate::path_task::PathTask;
use crate::integrate::scatter_point_guide::{GuidedDistanceDistribution, InScatteringSample};
use crate::integrate::vertex::MediumPathSegment;
use crate::light::ShadowTarget;
use crate::math::Ray;
use crate::medium::DistanceSample;
use crate::sampling::{Dimension, Sampler};
use crate::scene::{Effect, Interior, MediumSegment};
use glam::{Vec2, Vec3};

/// Fraction of the scattering points (starts of shadow rays) on a medium segment that ignore the
/// learned distribution (defensive sampling).
///
/// The fraction bounds the weight of a guided point: at most 1/0.25 = 4 times its weight without
/// guiding.
const DEFENSIVE_FRACTION: f32 = 0.25;

/// Smallest expected number of guided scattering points (starts of shadow rays) on a medium
/// segment, divided by the number of shadow rays that a surface point would send. Russian roulette
/// decides if a segment gets points when this ratio is below 1.
const MIN_RELATIVE_POINT_COUNT: f32 = 0.125;
/// Largest expected number of guided scattering points (starts of shadow rays) on a medium segment,
/// divided by the number of shadow rays that a surface point would send.
const MAX_RELATIVE_POINT_COUNT: f32 = 16.0;

/// Number of scattering points (starts of shadow rays) on a medium segment in the pilot that
/// records the light of shadow rays, divided by the number of shadow rays that a surface point
/// would send.
const RECORDED_RELATIVE_POINT_COUNT: f32 = 12.0;

/// Sampled scattering point, from which a shadow ray starts, on a segment of a camera path through
/// a medium.
struct ScatterPoint {
    p: Vec3,
    /// Scattering coefficient σs times the transmittance to the start of the segment, divided by
    /// the pdf of the distance.
    weight: Rgb,
}

impl NextEventEstimator<'_> {
    /// Estimates the direct light that a medium scatters to the start of a segment \[W/(m² sr)].
    ///
    /// `distance_sample` holds the distance at which the path itself scatters. If `continues` is
    /// true, the path continues from there, and its next ray may hit the same light. The
    /// contribution of the light is then multiplied by the MIS weight (balance heuristic) of shadow
    /// rays against that ray. Delta lights have no such weight, because no ray hits them.
    pub fn estimate_direct_light_in_medium<I: Interior>(
        &self,
        path_segment: &MediumPathSegment<'_, I>,
        distance_sample: &DistanceSample,
        continues: bool,
        task: &mut PathTask,
    ) -> Rgb {
        let segment = path_segment.segment;
        let path_point = || {
            let t = distance_sample.scattering_distance?;
            Some(ScatterPoint { p: segment.ray.at(t), weight: distance_sample.weight })
        };
        let mut sum = Rgb::ZERO;
        match (self.shadow_ray_scheme(path_segment.history), &self.light_sampler) {
            (ShadowRayScheme::EveryLight(rays), _) => {
                for (i, light) in self.lights.iter().enumerate() {
                    let rays = if !light.is_delta() && !self.aims_at_centers { rays } else { 1 };
                    let sampler = path_segment.shadow_sampler.nth_shadow_ray_sampler(i);
                    if segment.medium.is_homogeneous() && path_segment.history.receivers == 0 {
                        let guided = self.estimate_at_guided_points(i, rays, path_segment, sampler, continues, task);
                        if let Some(found) = guided {
                            sum += found;
                            continue;
                        }
                    }
                    for ray in 0..rays {
                        let sampler = sampler.subsample_sampler(ray, rays);
                        let pivot = light.representative_point().filter(|_| segment.medium.is_homogeneous());
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
                                task,
                            );
                        }
                    }
                }
            }
            (ShadowRayScheme::RandomLights(rays), Some(light_sampler)) => {
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
                        task,
                    );
                }
            }
            (ShadowRayScheme::RandomLights(_), None) => {}
        }
        sum
    }

    /// Estimates the direct light that a homogeneous medium scatters to the start of a segment
    /// \[W/(m² sr)], from the light with index `light`. Shadow rays start from several points.
    ///
    /// Returns `None` if [`ScatterPointSampling`] is `Unguided`. If it is `Recorded`, adds the
    /// light that each shadow ray found to the records of `task`. `rays` is the number of shadow
    /// rays that a surface point sends to the light.
    fn estimate_at_guided_points<I: Interior>(
        &self,
        light: usize,
        rays: u32,
        path_segment: &MediumPathSegment<'_, I>,
        sampler: Sampler,
        continues: bool,
        task: &mut PathTask,
    ) -> Option<Rgb> {
        let MediumSegment { ray, medium, .. } = path_segment.segment;
        let mut guided = std::mem::take(&mut task.scratch.guided_distances);
        guided.clear();

        // Find how many points the segment needs.
        let (expected_count, records) = match &self.guides.scatter_points {
            ScatterPointSampling::Unguided => return None,
            ScatterPointSampling::Recorded => (RECORDED_RELATIVE_POINT_COUNT, true),
            ScatterPointSampling::Guided { guide, points_per_radiance } => {
                guide.distances_along(light, ray, color::channel_mean(medium.extinction()), &mut guided);
                let scattered =
                    color::channel_mean(path_segment.throughput * medium.scattering) * guided.total_weight();
                let wanted =
                    (scattered * points_per_radiance).clamp(MIN_RELATIVE_POINT_COUNT, MAX_RELATIVE_POINT_COUNT);
                (if wanted > 1.0 { wanted.round() } else { wanted }, false)
            }
        };
        let plays_roulette = expected_count < 1.0;
        let count = if !plays_roulette {
            rays * expected_count as u32
        } else if sampler.get_1d(Dimension::ShadingRoulette) < expected_count {
            rays
        } else {
            0
        };

        // Send shadow rays from the points.
        let points = ScatterPointDistribution {
            path_segment,
            angles: self.lights[light].representative_point().map(|pivot| EquiangularDistribution::new(ray, pivot)),
            guided: (guided.total_weight() > 0.0).then_some(&guided),
        };
        let mut sum = Rgb::ZERO;
        for i in 0..count {
            let sampler = sampler.subsample_sampler(i, count);
            let Some(point) = points.sample(sampler) else { continue };
            let found = self.shadow_ray_contribution_in_medium(
                &point,
                light,
                path_segment,
                sampler,
                rays as f32,
                continues,
                task,
            );
            sum += found;
            // The transmittance of a dense medium may underflow. The weight is then 0, and the ray
            // tells nothing about the scattered radiance.
            let weight = color::channel_mean(point.weight);
            if records && weight > 0.0 {
                let scattered_radiance = f64::from(color::channel_mean(found) / weight);
                let contribution = f64::from(color::channel_mean(path_segment.throughput * found) / expected_count);
                task.records.in_scattering_samples.push(InScatteringSample {
                    light,
                    p: point.p,
                    scattered_radiance,
                    contribution,
                });
            }
        }
        task.scratch.guided_distances = guided;
        Some(sum / expected_count)
    }

    /// Returns the radiance \[W/(m² sr)] that one shadow ray from `point` to the light with index
    /// `light` adds at the start of the segment. If the path `continues`, the radiance includes the
    /// MIS weight.
    ///
    /// `rays` is the expected number of shadow rays to that light; the radiance is divided by this
    /// number.
    #[expect(clippy::too_many_arguments, reason = "one call's inputs, all of different kinds")]
    fn shadow_ray_contribution_in_medium<I: Interior>(
        &self,
        point: &ScatterPoint,
        light: usize,
        path_segment: &MediumPathSegment<'_, I>,
        sampler: Sampler,
        rays: f32,
        continues: bool,
        task: &mut PathTask,
    ) -> Rgb {
        let segment = path_segment.segment;
        let u = if self.aims_at_centers { CENTER } else { sampler.get_2d(Dimension::LightPosition) };
        let Some(sample) = self.sample_li(light, point.p, u) else { return Rgb::ZERO };
        // Light arrives along −`wi` and leaves along the reversed ray direction: the two signs
        // cancel.
        let phase = segment.medium.phase.evaluate(segment.ray.direction.dot(sample.wi));
        let mut scattered = point.weight * sample.weight * (phase / rays);
        if scattered == Rgb::ZERO {
            return Rgb::ZERO;
        }
        if let (true, Some(pdf), false) = (continues, sample.pdf, self.aims_at_centers) {
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
            task.counters.shadow_rays += 1;
            if self.scene.occluded(&ray) {
                return if self.shadow_rays_cross_surfaces {
                    scattered
                        * self.scene.shadow_transmittance(&ray, segment.interior, self.effects, sampler.sample_key())
                } else {
                    Rgb::ZERO
                };
            }
        }
        let ray = Ray { t_max, ..Ray::new(point.p, sample.wi) };
        scattered * self.scene.interior_transmittance(&ray, &segment.interior, sampler.sample_key())
    }
}

/// Samples a scattering point, from which a shadow ray to one light starts, on a segment in a
/// homogeneous medium. `pivot` is the position of a point light, or a representative point of
/// another light.
///
/// Returns `None` if the sampled distance is beyond the segment.
fn sample_scatter_point_near<I: Interior>(
    path_segment: &MediumPathSegment<'_, I>,
    pivot: Vec3,
    sampler: Sampler,
) -> Option<ScatterPoint> {
    let angles = Some(EquiangularDistribution::new(&path_segment.segment.ray, pivot));
    ScatterPointDistribution { path_segment, angles, guided: None }.sample(sampler)
}

/// Distribution of scattering points on a segment in a homogeneous medium. Shadow rays to one light
/// start from these points.
///
/// If a pilot has learned a distribution of distances, three of four points follow it. All other
/// points are sampled in two ways. Half of them are sampled by transmittance. The other half are
/// equiangular: uniform in the angle seen from the light (Kulla and Fajardo 2012, "Importance
/// Sampling Techniques for Path Tracing in Participating Media"). For a light at infinity, all of
/// them are sampled by transmittance.
struct ScatterPointDistribution<'a, I> {
    path_segment: &'a MediumPathSegment<'a, I>,
    angles: Option<EquiangularDistribution>,
    /// Distribution of distances along the ray that a pilot has learned (guiding); `None` without
    /// guiding, or if the pilot found no light on the ray.
    guided: Option<&'a GuidedDistanceDistribution>,
}

impl<I: Interior> ScatterPointDistribution<'_, I> {
    /// Samples a scattering point, from which a shadow ray starts. Returns `None` if the sampled
    /// distance is beyond the segment.
    fn sample(&self, sampler: Sampler) -> Option<ScatterPoint> {
        let MediumSegment { ray, medium, .. } = self.path_segment.segment;
        let mut rng = sampler.sample_key().shadow_ray_scatter_point_key().rng();
        let Vec2 { x: choice, y: u } = sampler.get_2d(Dimension::ScatterPoint);
        let guided_fraction = if self.guided.is_some() { 1.0 - DEFENSIVE_FRACTION } else { 0.0 };
        let angle_fraction = if self.angles.is_some() { 0.5 * (1.0 - guided_fraction) } else { 0.0 };
        let t = match (self.guided, &self.angles) {
            (Some(guided), _) if choice < guided_fraction => guided.sample(u),
            (_, Some(angles)) if choice >= 1.0 - angle_fraction => angles.sample(u),
            _ => medium.distance_sample(ray, ray.t_max, self.path_segment.throughput, &mut rng).scattering_distance?,
        };
        let pdf = guided_fraction * self.guided.map_or(0.0, |guided| guided.pdf(t))
            + angle_fraction * self.angles.as_ref().map_or(0.0, |angles| angles.pdf(t))
            + (1.0 - guided_fraction - angle_fraction) * medium.distance_pdf(t, self.path_segment.throughput)?;
        if !(t >= 0.0 && t <= ray.t_max && pdf > 0.0) {
            return None;
        }
        let transmittance = medium.transmittance(ray, t, &mut rng);
        Some(ScatterPoint { p: ray.at(t), weight: transmittance * medium.scattering / pdf })
    }
}

/// Equiangular distribution of distances along a ray: uniform in the angle seen from a pivot point,
/// such as a point light (Kulla and Fajardo 2012).
struct EquiangularDistribution {
    /// Distance along the ray from its origin to the position closest to the pivot \[length].
    closest_point_t: f32,
    /// Smallest distance between the ray's line and the pivot \[length].
    pivot_distance: f32,
    /// Angle at the pivot between the closest point of the ray's line and the start of the ray
    /// \[rad]. It is negative if the ray starts before the closest point.
    start_angle: f32,
    /// Angle at the pivot between the closest point of the ray's line and the end of the ray
    /// \[rad]. It is negative if the ray ends before the closest point.
    end_angle: f32,
}

impl EquiangularDistribution {
    fn new(ray: &Ray, pivot: Vec3) -> Self {
        let to = pivot - ray.origin;
        let closest_distance = to.dot(ray.direction);
        // Any positive distance is unbiased. With a distance below rounding errors, all samples
        // would fall on the closest point.
        let pivot_distance =
            (to - ray.direction * closest_distance).length().max(1e-5 * to.length()).max(f32::MIN_POSITIVE);
        let angle = |t: f32| libm::atanf((t - closest_distance) / pivot_distance);
        Self { closest_point_t: closest_distance, pivot_distance, start_angle: angle(0.0), end_angle: angle(ray.t_max) }
    }

    /// Returns the distance along the ray for uniform `u` in \[0, 1) \[length].
    fn sample(&self, u: f32) -> f32 {
        self.closest_point_t
            + self.pivot_distance * libm::tanf(self.start_angle + (self.end_angle - self.start_angle) * u)
    }

    /// Returns the pdf of distance `t` along the ray \[1/length].
    fn pdf(&self, t: f32) -> f32 {
        let x = (t - self.closest_point_t) / self.pivot_distance;
        let range = self.end_angle - self.start_angle;
        if range > 0.0 { 1.0 / (self.pivot_distance * (1.0 + x * x) * range) } else { 0.0 }
    }
}
