//! Next-event estimation: direct light at surfaces and in media, by shadow rays.

mod medium;

use super::environment_guide::EnvironmentGuide;
use super::path_task::PathTask;
use super::policy::{DirectionSampling, LightSampling, PathPolicy};
use super::scatter;
use super::scatter_point_guide::ScatterPointGuide;
use super::vertex::{PathHistory, PathVertex, PrevVertex};
use crate::color::Rgb;
use crate::light::{DirectLightSample, EnvironmentLight, Light, LightBvhSampler, ShadowTarget};
use crate::sampling::Dimension;
use crate::scene::{Effect, Effects, Interior, Scene};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// Sample of the unit square that maps to the center of a light.
const CENTER: Vec2 = Vec2::splat(0.5);

/// Number of lights up to which a vertex sends a shadow ray to every light, in algorithms with one
/// shadow ray per vertex. With more lights, and beyond a path's first receiver (surface or medium
/// that stores photons), the shadow ray goes to a randomly chosen light.
const FEW_LIGHTS: usize = 4;

/// Number of shadow rays that a vertex sends, and the lights to which it sends them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ShadowRayScheme {
    /// Every light gets this many shadow rays. Delta lights, and lights that are sampled at their
    /// center, get only one, because further rays would be equal.
    EveryLight(u32),
    /// A vertex sends this many shadow rays, each to a randomly chosen light.
    RandomLights(u32),
}

/// Distributions that pilots have learned for shadow rays: one for directions to the environment
/// light, and one for scattering points, the points in media from which shadow rays start.
#[derive(Clone, Debug, Default)]
pub(super) struct ShadowRayGuides {
    /// Learned distribution of directions to the environment light; `None` samples directions from
    /// the light's own distribution.
    pub environment: Option<Arc<EnvironmentGuide>>,
    /// Method that chooses scattering points: the points in homogeneous media from which shadow
    /// rays start.
    pub scatter_points: ScatterPointSampling,
}

/// Method that chooses scattering points: the points in a homogeneous medium from which shadow rays
/// start. The method applies to segments of a camera path before its first receiver (surface or
/// medium that stores photons).
#[derive(Clone, Debug, Default)]
pub(super) enum ScatterPointSampling {
    /// Scattering points (points in a medium from which shadow rays start) follow no learned
    /// distribution. A medium segment has at most as many scattering points as a surface point
    /// would send shadow rays.
    #[default]
    Unguided,
    /// Scattering points (points in a medium from which shadow rays start) follow no learned
    /// distribution. Each medium segment gets many of them, and the light that each of their shadow
    /// rays finds is recorded. A pilot (small simulation before the first pass) learns from these
    /// records where direct light arrives.
    Recorded,
    /// Scattering points (points in a medium from which shadow rays start) follow a distribution
    /// that a pilot has learned: most lie where direct light arrives.
    Guided {
        guide: Arc<ScatterPointGuide>,
        /// Factor c \[m² sr/W]: a medium segment gets about c·L scattering points (starts of shadow
        /// rays) for each light, within bounds. L is the radiance that this light adds to the pixel
        /// by scattering once on the segment, as predicted from `guide`.
        points_per_radiance: f32,
    },
}

/// Estimator of direct light at the vertices of camera paths, by shadow rays.
#[derive(Debug)]
pub(super) struct NextEventEstimator<'a> {
    scene: &'a Scene,
    lights: &'a [Light],
    effects: Effects,
    directions: DirectionSampling,
    /// True if shadow rays cross some surfaces: null interfaces and thin sheets.
    shadow_rays_cross_surfaces: bool,
    /// True if shadow rays go to the centers of lights instead of random points.
    aims_at_centers: bool,
    /// Sampler that chooses lights at random for shadow rays; `None` if every vertex sends shadow
    /// rays to all lights, or if no light has power.
    light_sampler: Option<LightBvhSampler>,
    /// Numbers and targets of the shadow rays of a vertex. The first scheme is for vertices up to
    /// the path's first receiver (surface or medium that stores photons), the second for later
    /// vertices.
    schemes: [ShadowRayScheme; 2],
    guides: ShadowRayGuides,
}

impl<'a> NextEventEstimator<'a> {
    /// Makes an estimator of the direct light that `policy` simulates. Its shadow rays follow the
    /// learned distributions in `guides`.
    pub fn new(scene: &'a Scene, policy: &PathPolicy, mut guides: ShadowRayGuides) -> Self {
        let PathPolicy { effects, light_sampling, directions, .. } = *policy;
        // A light that is sampled only at its center needs its mean radiance there.
        let aims_at_centers = light_sampling == LightSampling::Centers || !effects.has(Effect::SoftShadows);
        let all = if aims_at_centers || !effects.has(Effect::Textures) {
            scene.mean_emission_lights()
        } else {
            scene.lights()
        };
        let skipped = scene.environment_light_index().filter(|_| !effects.has(Effect::Environment));
        // The environment is the last of the lights, so a shorter slice leaves it out.
        debug_assert!(skipped.is_none_or(|index| index + 1 == all.len()));
        let lights = &all[..skipped.unwrap_or(all.len())];
        let sampled = |n: u32| {
            let surfaces = if aims_at_centers { 1 } else { lights.iter().filter(|l| !l.is_delta()).count() as u32 };
            if lights.len() > n as usize {
                ShadowRayScheme::RandomLights(n)
            } else {
                ShadowRayScheme::EveryLight((n / surfaces.max(1)).max(1))
            }
        };
        let schemes = match light_sampling {
            LightSampling::Centers => [ShadowRayScheme::EveryLight(1); 2],
            LightSampling::Rays(n) => [sampled(n); 2],
            LightSampling::OneRay if lights.len() <= FEW_LIGHTS => [ShadowRayScheme::EveryLight(1), sampled(1)],
            LightSampling::OneRay => [sampled(1); 2],
        };
        let light_sampler = if schemes.iter().any(|s| matches!(s, ShadowRayScheme::RandomLights(_))) {
            LightBvhSampler::new(lights, scene.photon_domain())
        } else {
            None
        };
        let shadow_rays_cross_surfaces = scene.shadow_rays_cross_surfaces();
        guides.environment = guides.environment.filter(|_| !aims_at_centers && effects.has(Effect::Shadows));
        Self {
            scene,
            lights,
            effects,
            directions,
            shadow_rays_cross_surfaces,
            aims_at_centers,
            light_sampler,
            schemes,
            guides,
        }
    }

    /// Returns the number of lights to which every vertex and medium segment sends shadow rays, up
    /// to a path's first receiver (surface or medium that stores photons). This is the number of
    /// all lights, or 0 if shadow rays go to randomly chosen lights.
    pub fn always_sampled_light_count(&self) -> usize {
        match self.schemes[0] {
            ShadowRayScheme::EveryLight(_) => self.lights.len(),
            ShadowRayScheme::RandomLights(_) => 0,
        }
    }

    /// Returns the environment light, if its shadow rays could follow a learned distribution of
    /// directions.
    ///
    /// Returns `None` if the scene has no environment light, or if its effect or the effect of
    /// shadows is off. Also returns `None` if shadow rays go to the centers of lights.
    pub fn guidable_environment_light(&self) -> Option<&EnvironmentLight> {
        let environment = self.lights.iter().find_map(Light::as_environment_light)?;
        (!self.aims_at_centers && self.effects.has(Effect::Shadows)).then_some(environment)
    }

    /// Samples the direct light that arrives at `p` from the light with index `light`, by the
    /// uniform sample `u` in \[0, 1)². Returns `None` if no light reaches `p`.
    #[inline]
    fn sample_li(&self, light: usize, p: Vec3, u: Vec2) -> Option<DirectLightSample> {
        match (&self.lights[light], &self.guides.environment) {
            (Light::Environment(environment), Some(guide)) => guide.sample_li(environment, p, u),
            (light, _) => light.sample_li(p, u),
        }
    }

    /// Returns the pdf \[1/sr] with which [`NextEventEstimator::sample_li`] samples unit direction
    /// `wi` at `p`. `hit` is the point on the light; `None` for the environment.
    #[inline]
    fn pdf_li(&self, light: usize, p: Vec3, wi: Vec3, hit: Option<&SurfacePoint>) -> f32 {
        match (&self.lights[light], &self.guides.environment) {
            (Light::Environment(environment), Some(guide)) => guide.pdf_li(environment, p, wi),
            (light, _) => light.pdf_li(p, wi, hit),
        }
    }

    /// Returns the scheme of shadow rays for a vertex. `history` counts the receivers (surfaces and
    /// media that store photons) and casters that the path has visited before the vertex.
    fn shadow_ray_scheme(&self, history: PathHistory) -> ShadowRayScheme {
        self.schemes[usize::from(history.receivers > 0)]
    }

    /// Estimates the direct light that `vertex` scatters towards the previous vertex \[W/(m² sr)].
    ///
    /// If `continues` is true, the next ray of the path may hit the same light. The contribution of
    /// the light is then multiplied by the MIS weight (balance heuristic) of shadow rays against
    /// that ray. Delta lights have no such weight, because no ray hits them.
    pub fn estimate_direct_light<I: Interior>(
        &self,
        vertex: &PathVertex<'_, I>,
        continues: bool,
        task: &mut PathTask,
    ) -> Rgb {
        let rays = match (self.shadow_ray_scheme(vertex.history), &self.light_sampler) {
            (ShadowRayScheme::EveryLight(rays), _) => rays,
            (ShadowRayScheme::RandomLights(rays), Some(sampler)) => {
                return self.estimate_sampled_lights(sampler, rays, vertex, continues, task);
            }
            (ShadowRayScheme::RandomLights(_), None) => return Rgb::ZERO,
        };
        let mut sum = Rgb::ZERO;
        for (i, light) in self.lights.iter().enumerate() {
            let rays = if !light.is_delta() && !self.aims_at_centers { rays } else { 1 };
            let sampler = vertex.shadow_sampler.nth_shadow_ray_sampler(i);
            for ray in 0..rays {
                // Stratify the rays over the light.
                let u = if self.aims_at_centers {
                    CENTER
                } else {
                    sampler.subsample_sampler(ray, rays).get_2d(Dimension::LightPosition)
                };
                sum += self.shadow_ray_contribution(i, vertex, u, rays as f32, continues, task);
            }
        }
        sum
    }

    /// Estimates the direct light at `vertex` by `rays` shadow rays, each to a light that
    /// `light_sampler` chooses at random. All else is as in
    /// [`NextEventEstimator::estimate_direct_light`].
    fn estimate_sampled_lights<I: Interior>(
        &self,
        light_sampler: &LightBvhSampler,
        rays: u32,
        vertex: &PathVertex<'_, I>,
        continues: bool,
        task: &mut PathTask,
    ) -> Rgb {
        let point = &vertex.surface.point;
        let mut sum = Rgb::ZERO;
        // Choose lights by equal strata with one random shift. So no light gets more rays than its
        // expected number of rays, rounded up.
        let start = vertex.shadow_sampler.get_1d(Dimension::Light);
        for i in 0..rays {
            let u = stratified_sample(i, start, rays);
            let Some((light, probability, _)) = light_sampler.sample(point.p, vertex.scattering_hemisphere(), u) else {
                continue;
            };
            let sampler = vertex.shadow_sampler.nth_shadow_ray_sampler(i as usize);
            let u = if self.aims_at_centers { CENTER } else { sampler.get_2d(Dimension::LightPosition) };
            sum += self.shadow_ray_contribution(light, vertex, u, probability * rays as f32, continues, task);
        }
        sum
    }

    /// Returns the expected number of shadow rays from `prev` to the light with index `light`, per
    /// steradian around unit direction `wi` \[1/sr]. MIS weights use it as a pdf.
    ///
    /// `hit` is the point on the light; `None` for the environment.
    #[inline]
    pub fn mis_pdf(&self, prev: &PrevVertex, light: usize, wi: Vec3, hit: Option<&SurfacePoint>) -> f32 {
        let rays = match (self.shadow_ray_scheme(prev.history), &self.light_sampler) {
            (ShadowRayScheme::EveryLight(rays), _) => rays as f32,
            (ShadowRayScheme::RandomLights(rays), Some(sampler)) => {
                sampler.probability(prev.p, prev.hemisphere, light) * rays as f32
            }
            (ShadowRayScheme::RandomLights(_), None) => 0.0,
        };
        rays * self.pdf_li(light, prev.p, wi, hit)
    }

    /// Returns the radiance \[W/(m² sr)] that one shadow ray to the light with index `light` adds
    /// at `vertex`. If the path `continues`, the radiance includes the MIS weight.
    ///
    /// `rays` is the expected number of shadow rays to that light; the radiance is divided by this
    /// number. `u` in \[0, 1)² samples a point of the light.
    #[inline]
    fn shadow_ray_contribution<I: Interior>(
        &self,
        light: usize,
        vertex: &PathVertex<'_, I>,
        u: Vec2,
        rays: f32,
        continues: bool,
        task: &mut PathTask,
    ) -> Rgb {
        let surface = vertex.surface;
        let Some(sample) = self.sample_li(light, surface.point.p, u) else {
            return Rgb::ZERO;
        };
        let mut reflected = surface.bsdf_cosine(sample.wi) * sample.weight / rays;
        if reflected == Rgb::ZERO {
            return Rgb::ZERO;
        }
        if let (true, Some(pdf), false) = (continues, sample.pdf, self.aims_at_centers) {
            let light_pdf = rays * pdf;
            reflected *= light_pdf / (light_pdf + scatter::pdf(self.directions, vertex, sample.wi, task));
        }
        if !self.effects.has(Effect::Shadows) {
            return reflected * self.transmittance(vertex, &sample);
        }
        task.counters.shadow_rays += 1;
        let ray = match sample.target {
            ShadowTarget::Point(target) => {
                surface.spawn_ray_to(self.shadow_ray_end(light, &sample, target, surface.point.p), sample.wi)
            }
            ShadowTarget::Infinity => surface.spawn_ray(sample.wi),
        };
        if self.scene.occluded(&ray) {
            return if self.shadow_rays_cross_surfaces {
                reflected * self.transmittance_through_surfaces(light, vertex, &sample)
            } else {
                Rgb::ZERO
            };
        }
        reflected * self.transmittance(vertex, &sample)
    }

    /// Returns the point at which a shadow ray from `p` to `target` ends. `target` lies on the
    /// light with index `light`.
    ///
    /// The ray ends at `target`, except for a delta light, which may touch the surface of an
    /// object. There the ray ends shortly before the light.
    #[inline]
    fn shadow_ray_end(&self, light: usize, sample: &DirectLightSample, target: Vec3, p: Vec3) -> Vec3 {
        if sample.pdf.is_some() {
            return target;
        }
        target - sample.wi * self.scene.light_contact_distance(light).min(0.5 * (target - p).length())
    }

    /// Returns the transmittance of the shadow ray from `vertex` to `sample`, a point of a light.
    /// The ray must hit at least one surface. The result is 0 if one of these surfaces is neither a
    /// null interface nor a thin sheet.
    fn transmittance_through_surfaces<I: Interior>(
        &self,
        light: usize,
        vertex: &PathVertex<'_, I>,
        sample: &DirectLightSample,
    ) -> Rgb {
        let path_ray = vertex.outgoing_path_ray(sample.wi);
        let ray = match sample.target {
            ShadowTarget::Point(target) => vertex
                .surface
                .spawn_ray_to(self.shadow_ray_end(light, sample, target, vertex.surface.point.p), sample.wi),
            ShadowTarget::Infinity => path_ray.ray,
        };
        self.scene.shadow_transmittance(&ray, path_ray.interior, self.effects, vertex.shadow_sampler.sample_key())
    }

    /// Returns the transmittance from `vertex` to the sampled point of a light, through the medium
    /// or absorbing body around the vertex. Surfaces on the way are ignored. For a light at
    /// infinity, only media count.
    #[inline]
    fn transmittance<I: Interior>(&self, vertex: &PathVertex<'_, I>, sample: &DirectLightSample) -> Rgb {
        match sample.target {
            ShadowTarget::Point(target) => {
                vertex.transmittance(self.scene, sample.wi, (target - vertex.surface.point.p).length())
            }
            ShadowTarget::Infinity if I::HAS_MEDIA_OR_WAVELENGTH => {
                vertex.transmittance(self.scene, sample.wi, f32::INFINITY)
            }
            ShadowTarget::Infinity => Rgb::ONE,
        }
    }
}

/// Returns sample `i` of `count` stratified samples of \[0, 1): (`i` + `start`)/`count`. `start` in
/// \[0, 1) is the position within the stratum, equal for all samples.
#[inline]
fn stratified_sample(i: u32, start: f32, count: u32) -> f32 {
    ((i as f32 + start) / count as f32).min(1.0 - f32::EPSILON / 2.0)
}
