//! `raycast`: ray casting with Phong's shading model as MIT course 6.837 defines it.
//!
//! The model has no shadows, no distance falloff and no ambient term.

use super::film_sampling::FilmSampling;
use super::integrator::Integrator;
use super::pass::{PassResult, ProgressMonitor, StageTimes};
use super::settings::CameraPathSettings;
use super::tiles::{self, FilmImage};
use crate::camera::{CropWindow, Filter};
use crate::color::Rgb;
use crate::math::Ray;
use crate::plan::Plan;
use crate::sampling::{Key, Purpose};
use crate::scene::{
    Effect, Effects, Hit, MeanParameterEvaluator, Mit6837Light, PhongAppearance, RayCone, Scene, SurfaceInteraction,
    TextureEvaluator,
};
use crate::stats::Counters;
use std::time::Instant;

/// Integrator of the algorithm `raycast`.
#[derive(Debug)]
pub(super) struct RaycastIntegrator<'a> {
    scene: &'a Scene,
    plan: Plan,
    /// Reconstruction filter; `None` sends one ray through the lower left corner of each pixel.
    filter: Option<Filter>,
    samples_per_pixel: u32,
    seed: u64,
    window: CropWindow,
}

impl Integrator for RaycastIntegrator<'_> {
    fn render_pass(&self, pass: u32, monitor: &dyn ProgressMonitor) -> PassResult {
        let start = Instant::now();
        let (camera, filter) = (self.scene.camera(), self.filter.as_ref());
        let samples = self.samples_per_pixel;
        let sampling = FilmSampling { window: self.window, ..FilmSampling::of_camera(camera, filter, samples, false) };
        let key = Key::new(self.seed).purpose_key(Purpose::CameraPaths).pass_key(pass);
        let FilmImage { image, counters, .. } =
            tiles::render_tiles(&sampling, key, monitor, |camera_ray, _, (): &mut ()| self.radiance(&camera_ray.ray));
        let seconds = StageTimes { camera: start.elapsed().as_secs_f64(), ..StageTimes::default() };
        PassResult { image, counters, seconds, ..PassResult::default() }
    }

    fn expected_work(&self, _: Effects) -> Counters {
        let (width, height) = self.scene.camera().size();
        let camera_rays = u64::from(width) * u64::from(height) * u64::from(self.samples_per_pixel);
        Counters { camera_rays, ..Counters::default() }
    }

    fn plan(&self) -> &Plan {
        &self.plan
    }
}

impl<'a> RaycastIntegrator<'a> {
    /// Makes an integrator that sends one ray through the lower left corner of each pixel. If
    /// `settings` ask for several rays per pixel, the rays follow the pixel filter instead.
    pub fn new(scene: &'a Scene, plan: Plan, settings: &CameraPathSettings) -> Self {
        let samples = settings.samples_per_pixel.unwrap_or(1);
        let filter = (samples > 1).then(|| settings.filter.clone());
        let window = settings.window(scene.camera().size());
        Self { scene, plan, filter, samples_per_pixel: samples, seed: settings.seed, window }
    }

    /// Returns the radiance along a camera ray by Phong's shading model \[W/(m² sr)].
    fn radiance(&self, ray: &Ray) -> Rgb {
        let mut ray = *ray;
        let mut cone = self.scene.camera_ray_cone(self.plan.simulated_effects());
        let (hit, surface) = loop {
            let Some(hit) = self.scene.intersect(&ray) else {
                return self.scene.background();
            };
            cone.widen_over_distance(hit.t);
            let surface = self.scene.surface_interaction(&ray, &hit, &cone, || 0.0);
            if !surface.is_null_interface() {
                break (hit, surface);
            }
            ray = surface.spawn_ray(ray.direction);
        };
        let appearance = phong_appearance(self.scene, &surface, &hit, &cone);
        surface.emission
            + self
                .scene
                .mit_6837_lights()
                .iter()
                .map(|light| phong_shading_of_light(&surface, &appearance, light))
                .sum::<Rgb>()
    }
}

/// Returns the Phong coefficients of the surface at `hit`.
fn phong_appearance(scene: &Scene, surface: &SurfaceInteraction<'_>, hit: &Hit, cone: &RayCone) -> PhongAppearance {
    let material = surface.material;
    if !(material.is_textured() && cone.effects.has(Effect::Textures)) {
        return material.kind().phong_appearance(&MeanParameterEvaluator);
    }
    let at = scene.texture_context(hit, &surface.point, surface.wo, cone);
    material.kind().phong_appearance(&TextureEvaluator { textures: scene.textures(), context: at })
}

/// Returns the light that a surface reflects by Phong's model, for one light of color c:
/// c·(kd·max(0, N·L) + ks·max(0, V·R)ˢ) with R = 2(N·L)N − L.
///
/// V is `surface.wo`, N the shading normal, and L the unit direction to the light. `appearance`
/// holds kd, ks and the exponent s. As defined in MIT course 6.837, surfaces that face away from
/// the light keep their highlight. Normals are not flipped towards the viewer, and 0⁰ is 1.
fn phong_shading_of_light(surface: &SurfaceInteraction<'_>, appearance: &PhongAppearance, light: &Mit6837Light) -> Rgb {
    let (to_light, color) = match light {
        Mit6837Light::Point(position, color) => ((*position - surface.point.p).normalize_or_zero(), *color),
        Mit6837Light::Directional(direction, color) => (-*direction, *color),
    };
    let n = surface.point.ns;
    let cos = n.dot(to_light);
    let mirror = n * (2.0 * cos) - to_light;
    let highlight = libm::powf(surface.wo.dot(mirror).max(0.0), appearance.shininess);
    color * (appearance.diffuse * cos.max(0.0) + appearance.specular * highlight)
}
