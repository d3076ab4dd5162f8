//! Surface AOVs (arbitrary output variables): albedo, normal, depth, position and identifiers of
//! the surfaces that the camera sees.
//!
//! AOVs need no light transport, so separate camera rays find them. They do not change the passes
//! of the picture.

use super::film_sampling::FilmSampling;
use super::pass::{PassStage, ProgressMonitor};
use super::settings::CameraPathSettings;
use crate::bsdf::TransportMode;
use crate::color::{self, Rgb};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{
    Effect, Effects, FilmMotionMeter, Interior, PathEvent, PathRay, Scene, SurfaceInteraction, with_interior_type,
};
use glam::{DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// Number of camera rays per pixel for the surface AOVs that are written as layers of files.
pub const SURFACE_AOV_RAYS: u32 = 32;

/// Number of BSDF samples at each hit that estimate its albedo.
const ALBEDO_SAMPLES: u32 = 4;

/// Largest number of specular surfaces at which a camera ray is reflected or refracted on the way
/// to the surface that the AOVs describe.
const MAX_SPECULAR_BOUNCES: u32 = 16;

/// Weight of a branch of a camera ray, as the mean of its RGB channels, below which the branch is
/// not followed.
///
/// Smooth dielectrics split a ray into a reflected and a refracted branch.
const MIN_WEIGHT: f32 = 0.01;

/// Choice of the surface along a camera ray that the AOVs describe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AovSurface {
    /// The AOVs describe the first surface that is not specular: rays continue at mirrors and
    /// smooth glass until they reach it.
    #[default]
    FirstNonSpecular,
    /// The AOVs describe the first surface that the camera ray hits.
    First,
}

/// Properties of the surfaces that the camera sees, by pixels in rows from the top.
///
/// Pixels without a surface have depth 0, position 0 and identifiers 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceAovs {
    /// Directional albedo in \[0, 1]: the fraction of light from the direction of the viewer that
    /// the surface scatters. On emitters, and where rays leave the scene, the value is the larger
    /// of the albedo and the radiance \[W/(m² sr)], clipped to 1.
    pub albedo: Vec<Rgb>,
    /// Shading normal in world space on the side of the viewer, as a mean over the pixel. Rays that
    /// leave the scene count as zero.
    pub normal: Vec<Vec3>,
    /// Length of the path from the camera to the surface \[length], as a mean over the rays that
    /// reach a surface.
    pub depth: Vec<f32>,
    /// Position in world space \[length], as a mean over the rays that reach a surface.
    pub position: Vec<Vec3>,
    /// Index of the object that most rays reach, counted from 1: shapes, then meshes, then planes.
    pub object_id: Vec<u32>,
    /// Index of the material that most rays reach, counted from 1 in the order of the scene.
    pub material_id: Vec<u32>,
    /// Motion on the film from the opening to the closing of the shutter \[pixels to the right and
    /// down], as a mean over the rays.
    ///
    /// The field holds the motion of the first surface that a ray meets, even if the surface is
    /// specular. If the ray meets no surface, the field holds the motion of the surroundings at
    /// infinity. A ray counts as zero if the point that it sees is behind the camera when the
    /// shutter opens or closes.
    pub motion: Vec<Vec2>,
}

/// AOVs (albedo, normal, depth and so on) of one pixel; see [`SurfaceAovs`] for units.
#[derive(Clone, Copy, Default)]
struct PixelAovs {
    albedo: Rgb,
    normal: Vec3,
    depth: f32,
    position: Vec3,
    object_id: u32,
    material_id: u32,
    motion: Vec2,
}

/// AOVs that one camera ray finds. Smooth dielectrics split the ray into a reflected and a
/// refracted branch; the AOVs combine all branches.
#[derive(Clone, Copy, Default)]
struct RayAovs {
    /// Albedo, as a weighted sum over the branches of the ray.
    albedo: Rgb,
    /// Shading normal, as a weighted mean over the branches of the ray.
    normal: Vec3,
    /// Surface at the end of the branch with the largest weight; `None` if no branch ends at a
    /// surface.
    heaviest: Option<BranchEndSurface>,
    /// Motion on the film of the first surface that the ray meets \[pixels to the right and down].
    /// If the ray meets no surface, the motion of the surroundings at infinity.
    motion: Vec2,
}

/// Surface at which one branch of a camera ray ends. Smooth dielectrics split a ray into a
/// reflected and a refracted branch.
#[derive(Clone, Copy)]
struct BranchEndSurface {
    /// Weight of the branch, as the mean of its channels.
    weight: f32,
    /// Length of the path from the camera to the surface \[length].
    depth: f32,
    position: DVec3,
    object_index: u32,
    material_index: u32,
}

/// State of one branch of a camera ray between two specular surfaces. Smooth dielectrics split a
/// ray into a reflected and a refracted branch.
#[derive(Clone, Copy)]
struct RayBranch<I> {
    path_ray: PathRay<I>,
    /// Factor from the albedo at the end of the branch to the albedo of the ray.
    weight: Rgb,
    /// Length of the path from the camera to the start of the current segment \[length].
    depth: f32,
    bounces: u32,
    sampler: Sampler,
}

/// Copy of the scene at one time of the shutter interval, with the options of its camera rays.
struct SceneAtTime<'a> {
    scene: &'a Scene,
    /// Time in \[0, 1]: 0 is the opening of the shutter, 1 its closing.
    time: f64,
    film: FilmSampling<'a>,
    /// Meter of the motion of scene points on the film; `None` if nothing moves.
    motion: Option<FilmMotionMeter>,
    effects: Effects,
    /// True if rays continue at specular surfaces until they reach a surface that is not specular,
    /// or leave the scene.
    follows_specular: bool,
}

/// Returns the surface AOVs of the pixels in the window of `settings`, from `rays` camera rays per
/// pixel; `None` if `monitor` is cancelled.
///
/// `surface` selects the surface along each ray. `effects` are the simulated effects of light;
/// media and dispersion do not affect AOVs.
#[must_use]
pub fn render_surface_aovs(
    scene: &Scene,
    effects: Effects,
    settings: &CameraPathSettings,
    surface: AovSurface,
    rays: u32,
    monitor: &dyn ProgressMonitor,
) -> Option<SurfaceAovs> {
    let effects = effects.without_effect(Effect::Media).without_effect(Effect::Dispersion);
    let follows_specular = surface == AovSurface::FirstNonSpecular && effects.has(Effect::Specular);
    let window = settings.window(scene.camera().size());
    let (width, height) = window.size();
    monitor.begin_stage(PassStage::Camera, u64::from(width) * u64::from(height));

    // Spread the rays of a pixel over the shutter interval.
    let motion = FilmMotionMeter::new(scene).filter(|_| effects.has(Effect::Motion));
    let times: Vec<f64> = (0..rays).map(|ray| (f64::from(ray) + 0.5) / f64::from(rays)).collect();
    let moved: Vec<Scene> =
        if motion.is_some() { times.iter().map(|time| scene.at_time(*time)).collect() } else { Vec::new() };
    let scenes = if motion.is_some() { &moved[..] } else { std::slice::from_ref(scene) };
    let scenes: Vec<SceneAtTime<'_>> = scenes
        .iter()
        .zip(times)
        .map(|(scene, time)| {
            let film = FilmSampling::of_camera(scene.camera(), Some(&settings.filter), rays, effects.has(Effect::Lens));
            SceneAtTime { scene, time, film, motion, effects, follows_specular }
        })
        .collect();

    let key = Key::new(settings.seed).purpose_key(Purpose::SurfaceAovs);
    let rows = (window.top..window.bottom).into_par_iter().map(|y| {
        let pixels = (window.left..window.right).map_while(|x| {
            let of_rays = (0..rays).map(|ray| {
                let sampler = Sampler::new(key.pixel_key(x, y), ray, rays);
                let at_time = &scenes[ray as usize % scenes.len()];
                let (camera_ray, weight) = at_time.film.generate_ray(0, Vec2::new(x as f32, y as f32), sampler);
                let found = with_interior_type!(effects, <I> {
                    let path_ray: PathRay<I> = at_time.scene.start_camera_path(camera_ray, effects);
                    trace_ray(at_time, path_ray, sampler)
                });
                (found, weight)
            });
            (!monitor.is_cancelled()).then(|| PixelAovs::from_rays(of_rays))
        });
        let row: Vec<PixelAovs> = pixels.collect();
        monitor.report_progress(width.into());
        row
    });
    let pixels: Vec<PixelAovs> = rows.flatten_iter().collect();
    (!monitor.is_cancelled()).then(|| SurfaceAovs {
        albedo: pixels.iter().map(|pixel| pixel.albedo).collect(),
        normal: pixels.iter().map(|pixel| pixel.normal).collect(),
        depth: pixels.iter().map(|pixel| pixel.depth).collect(),
        position: pixels.iter().map(|pixel| pixel.position).collect(),
        object_id: pixels.iter().map(|pixel| pixel.object_id).collect(),
        material_id: pixels.iter().map(|pixel| pixel.material_id).collect(),
        motion: pixels.iter().map(|pixel| pixel.motion).collect(),
    })
}

/// Follows a camera ray of `at_time`. The ray is reflected and refracted at specular surfaces if
/// `at_time.follows_specular` is true, and ends there otherwise. Returns the AOVs of the surface
/// that the ray reaches.
fn trace_ray<I: Interior>(at_time: &SceneAtTime<'_>, path_ray: PathRay<I>, sampler: Sampler) -> RayAovs {
    let SceneAtTime { scene, effects, follows_specular, .. } = *at_time;
    let mut found = RayAovs::default();
    let mut total_weight = 0.0;
    let mut branches = vec![RayBranch { path_ray, weight: Rgb::ONE, depth: 0.0, bounces: 0, sampler }];
    while let Some(mut branch) = branches.pop() {
        let hit = match branch.path_ray.next_vertex(scene, branch.sampler.sample_key(), |_| None) {
            PathEvent::Surface(hit) => hit,
            PathEvent::Scattered { .. } | PathEvent::Escaped { .. } => {
                let shows_environment = effects.has(Effect::Environment);
                let direction = branch.path_ray.ray.direction;
                let radiance = if shows_environment { scene.escaped_radiance(direction) } else { scene.background() };
                found.albedo += branch.weight * clip_to_albedo(radiance);
                total_weight += color::channel_mean(branch.weight);
                if branch.bounces == 0 {
                    found.motion = at_time.motion_of_direction(direction);
                }
                continue;
            }
        };
        branch.weight *= hit.absorption_and_wavelength_weight;
        branch.depth += hit.distance;
        let surface = &hit.surface;
        if branch.bounces == 0 {
            found.motion = at_time.motion_of_surface(&branch.path_ray, surface);
        }
        if follows_specular && surface.bsdf.is_specular() && !surface.stores_photons() {
            found.albedo += branch.weight * clip_to_albedo(surface.emission);
            if branch.bounces < MAX_SPECULAR_BOUNCES {
                branch.push_continuations(surface, &mut branches);
            }
            continue;
        }
        found.add_surface(scene, &branch, surface);
        total_weight += color::channel_mean(branch.weight);
    }
    if total_weight > 0.0 {
        found.normal /= total_weight;
    }
    found
}

impl SceneAtTime<'_> {
    /// Returns the motion on the film of `surface` at the end of `path_ray` \[pixels to the right
    /// and down]. Returns 0 if nothing moves, or if the surface is behind the camera when the
    /// shutter opens or closes.
    fn motion_of_surface<I>(&self, path_ray: &PathRay<I>, surface: &SurfaceInteraction<'_>) -> Vec2 {
        let Some(motion) = self.motion else { return Vec2::ZERO };
        let hit = self.scene.intersect(&path_ray.ray);
        let of_hit = |hit| motion.surface_point_displacement(self.scene, &hit, self.time, surface.point.p);
        hit.and_then(of_hit).unwrap_or(Vec2::ZERO)
    }

    /// Returns the motion on the film of the surroundings in unit `direction` \[pixels to the right
    /// and down]. Returns 0 if nothing moves, if the camera is orthographic, or if `direction` is
    /// behind the camera when the shutter opens or closes.
    fn motion_of_direction(&self, direction: Vec3) -> Vec2 {
        self.motion.and_then(|motion| motion.displacement_at_infinity(direction)).unwrap_or(Vec2::ZERO)
    }
}

/// Returns `color` clipped to \[0, 1].
fn clip_to_albedo(color: Rgb) -> Rgb {
    color.clamp(Rgb::ZERO, Rgb::ONE)
}

impl<I: Interior> RayBranch<I> {
    /// Adds to `branches` the rays that continue this branch at a specular `surface`: two at a
    /// smooth dielectric, else at most one.
    fn push_continuations(&self, surface: &SurfaceInteraction<'_>, branches: &mut Vec<Self>) {
        let mut push = |direction: Vec3, weight: Rgb, is_transmitted: bool| {
            let mut next = *self;
            next.weight *=
                weight * next.path_ray.leave_surface_with_wavelength_weight(surface, direction, is_transmitted);
            next.sampler = self.sampler.next_vertex_sampler(self.bounces, is_transmitted);
            next.bounces += 1;
            if color::channel_mean(next.weight) >= MIN_WEIGHT {
                branches.push(next);
            }
        };
        let (ns, ng) = (surface.point.ns, surface.point.ng);
        if let Some(split) = surface.bsdf.reflect_and_refract(surface.wo, ns, ng, TransportMode::Radiance) {
            push(split.reflected.0, Rgb::splat(split.reflected.1), false);
            push(split.transmitted.0, Rgb::splat(split.transmitted.1), true);
            return;
        }
        let (lobe, u) = (self.sampler.get_1d(Dimension::BsdfLobe), self.sampler.get_2d(Dimension::BsdfDirection));
        if let Some(sample) = surface.sample(lobe, u, TransportMode::Radiance) {
            push(sample.wi, sample.weight, sample.is_transmitted);
        }
    }
}

impl RayAovs {
    /// Adds the albedo and the normal of `surface`, where `branch` ends. If the branch has a larger
    /// weight than all earlier ones, also stores the surface in `heaviest`.
    fn add_surface<I: Interior>(&mut self, scene: &Scene, branch: &RayBranch<I>, surface: &SurfaceInteraction<'_>) {
        let albedo = directional_albedo(surface, branch.sampler).max(surface.emission);
        self.albedo += branch.weight * clip_to_albedo(albedo);
        let weight = color::channel_mean(branch.weight);
        let is_back = surface.wo.dot(surface.point.ng) < 0.0;
        self.normal += weight * if is_back { -surface.point.ns } else { surface.point.ns };
        if self.heaviest.is_none_or(|heaviest| weight > heaviest.weight)
            && let Some(hit) = scene.intersect(&branch.path_ray.ray)
        {
            let (object, material) = scene.object_and_material_index(&hit);
            let position = scene.origin() + surface.point.p.as_dvec3();
            self.heaviest = Some(BranchEndSurface {
                weight,
                depth: branch.depth,
                position,
                object_index: object,
                material_index: material,
            });
        }
    }
}

/// Estimates the directional albedo of `surface` for each channel: the fraction of light from the
/// direction of the viewer that it scatters.
fn directional_albedo(surface: &SurfaceInteraction<'_>, sampler: Sampler) -> Rgb {
    let weights = (0..ALBEDO_SAMPLES).filter_map(|i| {
        let sampler = sampler.subsample_sampler(i, ALBEDO_SAMPLES);
        let (lobe, u) = (sampler.get_1d(Dimension::BsdfLobe), sampler.get_2d(Dimension::BsdfDirection));
        surface.sample(lobe, u, TransportMode::Radiance).map(|sample| sample.weight)
    });
    weights.sum::<Rgb>() / ALBEDO_SAMPLES as f32
}

impl PixelAovs {
    /// Returns the AOVs of a pixel: means over its rays, and the object and the material that most
    /// rays reach.
    ///
    /// `rays` are pairs of a ray's AOVs and its filter weight. Rays without positive weight are
    /// left out, so that all values stay in their ranges. The others count equally.
    fn from_rays(rays: impl Iterator<Item = (RayAovs, f32)>) -> Self {
        let (mut albedo, mut normal, mut motion) = (DVec3::ZERO, DVec3::ZERO, DVec2::ZERO);
        let (mut depth, mut position) = (0.0, DVec3::ZERO);
        let (mut objects, mut materials) = (Vec::new(), Vec::new());
        let mut count = 0.0;
        for (ray, _) in rays.filter(|(_, weight)| *weight > 0.0) {
            count += 1.0;
            albedo += ray.albedo.as_dvec3();
            normal += ray.normal.as_dvec3();
            motion += ray.motion.as_dvec2();
            if let Some(heaviest) = ray.heaviest {
                depth += f64::from(heaviest.depth);
                position += heaviest.position;
                objects.push(heaviest.object_index);
                materials.push(heaviest.material_index);
            }
        }
        let (all, hits) = (f64::max(count, 1.0), f64::max(objects.len() as f64, 1.0));
        Self {
            albedo: clip_to_albedo((albedo / all).as_vec3()),
            normal: (normal / all).as_vec3(),
            depth: (depth / hits) as f32,
            position: (position / hits).as_vec3(),
            object_id: most_frequent_index(&mut objects).map_or(0, |index| index + 1),
            material_id: most_frequent_index(&mut materials).map_or(0, |index| index + 1),
            motion: (motion / all).as_vec2(),
        }
    }
}

/// Returns the index that occurs most often in `indices`, and the lowest such index if there are
/// several; `None` if `indices` is empty. Sorts `indices`.
fn most_frequent_index(indices: &mut [u32]) -> Option<u32> {
    indices.sort_unstable();
    let runs = indices.chunk_by(|a, b| a == b).map(|run| (run.len(), run[0]));
    runs.max_by_key(|(count, index)| (*count, std::cmp::Reverse(*index))).map(|(_, index)| index)
}

#[cfg(test)]
mod tests {
    use super::most_frequent_index;

    #[test]
    fn ties_give_the_lowest_index() {
        assert_eq!(most_frequent_index(&mut []), None);
        assert_eq!(most_frequent_index(&mut [7, 3, 7, 3, 9]), Some(3));
        assert_eq!(most_frequent_index(&mut [7, 3, 7, 3, 7]), Some(7));
    }
}
